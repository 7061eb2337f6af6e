// SPDX-License-Identifier: Apache-2.0
// Skeleton of the open image or stack, by the program quench: curves as an overlay, coloured by radius, and a table of
// branches. From another macro: runMacro("Quench_Skeleton.ijm", "threshold=100 theta1=1r"); the keys are open=FILE,
// threshold=T (a value, or LOW,HIGH, auto, otsu, thin), invert=1, theta1=LENGTH, quench=PROGRAM, save=FILE.tif, table=FILE.csv.

options = getArgument();
batch = is("Batch Mode");
file = option("open", "");
if (file != "") open(file);
if (nImages == 0) fail("Quench: open an image or a stack first.");
getDimensions(width, height, channels, slices, frames);
if (bitDepth == 24) fail("Quench: this image has colours; make it grey first: Image > Type > 8-bit.");
if (channels * frames > 1) fail("Quench: one channel and one time, please: Image > Duplicate...");

threshold = "auto";
inverted = 0;
if (is("binary")) threshold = "1";
step = 0;  // between values of the image, as calibrated
calibrated = 0;
if (bitDepth < 32) {
  step = abs(calibrate(1) - calibrate(0));
  if (calibrate(0) != 0 || calibrate(1) != 1) calibrated = 1;
}
getThreshold(lower, upper);  // as calibrated, too
given = option("threshold", "");
if (given != "") { lower = -1; upper = -1; }
if (lower != -1 || upper != -1) {
  threshold = digits(lower);
  if (nSlices > 1) Stack.getStatistics(count, mean, least, most);
  else getStatistics(count, mean, least, most);
  if (upper < most) {
    if (lower <= least) {  // what is dark: all but what is brighter
      if (step == 1) threshold = digits(upper + 1);
      else threshold = digits(upper + step / 2);
      inverted = 1;
    } else say("Quench: the threshold has an upper end, which is not used: all from " + digits(lower) + " on is taken.");
  }
}
threshold = option("threshold", threshold);
chosen = option("invert", "" + inverted);
inverted = parseInt(chosen);
theta1 = option("theta1", "0.5r");
program = call("ij.Prefs.get", "quench.program", "quench");
program = option("quench", program);
if (options == "") {
  Dialog.create("Quench: skeleton");
  Dialog.addString("The shape: values from", threshold, 12);
  Dialog.addMessage("a value, or auto, otsu, thin; LOW,HIGH: from LOW on, where connected to HIGH");
  Dialog.addCheckbox("all the rest instead: dark things", inverted);
  Dialog.addString("Branches stick out by at least", theta1, 12);
  Dialog.addMessage("0.5r: half a radius of what they leave; 8vox; 3.5abs");
  Dialog.addString("Program", program, 24);
  Dialog.show();
  threshold = Dialog.getString();
  inverted = Dialog.getCheckbox();
  theta1 = Dialog.getString();
  program = Dialog.getString();
  call("ij.Prefs.set", "quench.program", program);
}

title = getTitle();
image = getImageID();
folder = getDirectory("temp") + "quench-" + floor(random * 1e9) + File.separator;
File.makeDirectory(folder);
setBatchMode(true);
run("Duplicate...", "title=quench-input duplicate");
resetThreshold();
if (calibrated) run("32-bit");  // the program reads values as they are stored
saveAs("Tiff", folder + "image.tif");
close();
command = "" + quoted(program) + " run image.tif --threshold " + quoted(threshold) + " --theta1 " + quoted(theta1) +
          " --no-view --no-picture -o out";
if (inverted) command += " --invert";
if (nSlices > 1) command += " --theta2 inf";
showStatus("Quench: skeleton ...");
said = exec("sh", "-c", "cd " + quoted(folder) + " && { " + command + "; } 2>&1");
if (!File.exists(folder + "out" + File.separator + "skeleton.swc")) {
  remove(folder);
  fail("Quench: " + said);
}
drawn = draw(folder + "out" + File.separator + "skeleton.swc");
file = option("save", "");
if (file != "") saveAs("Tiff", file);
file = option("table", "");
if (file != "") File.copy(folder + "out" + File.separator + "branches.csv", file);
if (!batch) {
  setBatchMode("exit and display");
  open(folder + "out" + File.separator + "branches.csv");
  selectImage(image);
  resetThreshold;  // its red would hide the lines
}
print(said + drawn + " lines drawn into " + title);
remove(folder);

// Lines from sample to parent; the samples of a branch stand one after another, and are one line in an image.
function draw(file) {
  selectImage(image);
  getVoxelSize(dx, dy, dz, unit);
  rows = split(File.openAsString(file), "\n");
  count = 0;
  x = newArray(rows.length + 1);
  y = newArray(rows.length + 1);
  z = newArray(rows.length + 1);
  r = newArray(rows.length + 1);
  parent = newArray(rows.length + 1);
  most = 0;
  for (i = 0; i < rows.length; i++) {
    if (startsWith(rows[i], "#")) continue;
    cells = split(rows[i], " ");
    count++;
    x[count] = parseFloat(cells[2]) / dx + 0.5;  // the centre of the first pixel is 0 for Quench, 0.5 for ImageJ
    y[count] = parseFloat(cells[3]) / dy + 0.5;
    z[count] = round(parseFloat(cells[4]) / dz) + 1;
    r[count] = parseFloat(cells[5]);
    parent[count] = parseInt(cells[6]);
    most = maxOf(most, r[count]);
  }
  Overlay.remove;
  lines = 0;
  for (i = 1; i <= count; i++) {
    if (parent[i] < 1) continue;
    colour = hot((r[i] + r[parent[i]]) / 2 / most);
    setColor(colour);
    setLineWidth(maxOf(1, width / 500));
    Overlay.drawLine(x[parent[i]], y[parent[i]], x[i], y[i]);
    Overlay.add;  // a line of its own, with its own colour
    if (nSlices > 1) Overlay.setPosition(z[i]);
    lines++;
  }
  Overlay.show;
  return lines;
}

// From red (thin) to yellow (thick).
function hot(share) {
  green = toHex(round(40 + 200 * share));
  if (lengthOf(green) < 2) green = "0" + green;
  return "#ff" + green + "30";
}

// The value of "key=value" in the argument of the macro; values with blanks stand in [ ].
function option(key, otherwise) {
  text = " " + options + " ";
  at = indexOf(text, " " + key + "=");
  if (at < 0) return otherwise;
  rest = substring(text, at + lengthOf(key) + 2);
  if (startsWith(rest, "[")) return substring(rest, 1, indexOf(rest, "]"));
  return substring(rest, 0, indexOf(rest, " "));
}

// A number with all its digits.
function digits(number) {
  plain = "" + number;
  if (parseFloat(plain) == number) return plain;
  return d2s(number, -9);
}

function say(message) {
  if (batch) print(message);
  else showMessage("Quench", message);
}

function fail(message) {
  if (!batch) exit(message);
  print(message);  // without a window to close
  exit();
}

function quoted(word) { return "'" + replace(word, "'", "'\"'\"'") + "'"; }

function remove(folder) {
  out = folder + "out" + File.separator;
  if (File.exists(out)) {
    files = getFileList(out);
    for (i = 0; i < files.length; i++) deleted = File.delete(out + files[i]);
    deleted = File.delete(out);
  }
  files = getFileList(folder);
  for (i = 0; i < files.length; i++) deleted = File.delete(folder + files[i]);
  deleted = File.delete(folder);
}
