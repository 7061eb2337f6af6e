// SPDX-License-Identifier: Apache-2.0
// Local thickness of the open image or stack, by the program quench: opens the map of thickness, with a table of figures.
// From another macro or the command line: runMacro("Quench_Thickness.ijm", "threshold=100 invert=1"); the keys are
// open=FILE, threshold=T (a value, or LOW,HIGH, auto, otsu, thin), invert=1, quench=PROGRAM, save=FILE.tif.

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
program = call("ij.Prefs.get", "quench.program", "quench");
program = option("quench", program);
if (options == "") {
  Dialog.create("Quench: local thickness");
  Dialog.addString("The shape: values from", threshold, 12);
  Dialog.addMessage("a value, or auto, otsu, thin; LOW,HIGH: from LOW on, where connected to HIGH");
  Dialog.addCheckbox("measure the rest instead: pores, dark things", inverted);
  Dialog.addString("Program", program, 24);
  Dialog.show();
  threshold = Dialog.getString();
  inverted = Dialog.getCheckbox();
  program = Dialog.getString();
  call("ij.Prefs.set", "quench.program", program);
}

title = getTitle();
folder = getDirectory("temp") + "quench-" + floor(random * 1e9) + File.separator;
File.makeDirectory(folder);
setBatchMode(true);
run("Duplicate...", "title=quench-input duplicate");
resetThreshold();
if (calibrated) run("32-bit");  // the program reads values as they are stored
saveAs("Tiff", folder + "image.tif");
close();
command = "" + quoted(program) + " thickness image.tif --threshold " + quoted(threshold) + " -o thickness.tif --csv thickness.csv";
if (inverted) command += " --invert";
showStatus("Quench: thickness ...");
said = exec("sh", "-c", "cd " + quoted(folder) + " && { " + command + " --json report.json; } 2>&1");
if (!File.exists(folder + "thickness.tif")) {
  remove(folder);
  fail("Quench: " + said);
}
open(folder + "thickness.tif");
rename("Thickness of " + title);
lines = split(File.openAsString(folder + "thickness.csv"), "\n");
names = split(lines[0], ",");
values = split(lines[1], ",");
for (i = 0; i < names.length; i++) if (startsWith(names[i], "max")) most = parseFloat(values[i]);
setMinAndMax(0, most);
run("Fire");
file = option("save", "");
if (file != "") saveAs("Tiff", file);
if (!batch) {
  setBatchMode("exit and display");
  if (nSlices > 1) setSlice(floor(nSlices / 2) + 1);
  table = "Thickness";
  if (!isOpen(table)) Table.create(table);
  row = Table.size(table);
  Table.set("image", row, title, table);
  for (i = 0; i < names.length; i++) Table.set(names[i], row, parseFloat(values[i]), table);
  Table.update(table);
}
print(said);
remove(folder);

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
  files = getFileList(folder);
  for (i = 0; i < files.length; i++) deleted = File.delete(folder + files[i]);
  deleted = File.delete(folder);
}
