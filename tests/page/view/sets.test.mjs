// SPDX-License-Identifier: Apache-2.0
// The page in a browser against the program: for results of `quench run`, what the page shows for a slider is what the
// program computes. node sets.test.mjs QUENCH VIEWER_FOLDER; exit code 77 where there is no browser to look with.
// QUENCH_TEST_FULL=1: at higher resolutions.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [quench, viewer] = process.argv.slice(2);
const skip = (why) => {
  console.log(`SKIPPED: ${why}`);
  process.exit(77);
};
const browserFile = [process.env.CHROMIUM, "/usr/bin/chromium-headless-shell", "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
  .find((file) => file && existsSync(file));
if (!browserFile) skip("there is no Chromium");
let launcher;
try {
  launcher = createRequire(join(viewer, "package.json"))("playwright-core").chromium;
} catch {
  skip("playwright-core is not installed");
}

const folder = mkdtempSync(join(tmpdir(), "quench-view-"));
const run = (...words) => execFileSync(quench, [...words, "--quiet"], { cwd: folder, stdio: ["ignore", "pipe", "inherit"] });

/// Area, length of edges without face, their free ends, and numbers of cells, of an OBJ file of the program.
function measure(file) {
  const points = [], lines = [], faces = [];
  for (const line of readFileSync(join(folder, file), "utf8").split("\n")) {
    const [kind, ...rest] = line.split(" ");
    if (kind === "v") points.push(rest.map(Number));
    else if (kind === "l") for (let i = 1; i < rest.length; ++i) lines.push([rest[i - 1] - 1, rest[i] - 1]);
    else if (kind === "f") faces.push(rest.map((word) => parseInt(word, 10) - 1));
  }
  const minus = (a, b) => [0, 1, 2].map((k) => points[a][k] - points[b][k]);
  const sides = new Set(), degree = new Map();
  const key = (a, b) => (a < b ? `${a} ${b}` : `${b} ${a}`);
  let area = 0, curveLength = 0;
  for (const f of faces) {
    const sum = [0, 0, 0];
    for (let i = 0; i < f.length; ++i) {
      sides.add(key(f[i], f[(i + 1) % f.length]));
      if (i < 2) continue;
      const u = minus(f[i - 1], f[0]), v = minus(f[i], f[0]);
      for (let k = 0; k < 3; ++k) sum[k] += u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    }
    area += Math.hypot(...sum) / 2;
  }
  const seen = new Set(sides);
  for (const [a, b] of lines) {
    if (!sides.has(key(a, b))) curveLength += Math.hypot(...minus(a, b));
    seen.add(key(a, b));
  }
  for (const edge of seen) for (const v of edge.split(" ")) degree.set(v, (degree.get(v) ?? 0) + 1);
  const freeEnds = [...degree.values()].filter((n) => n === 1).length;
  return { area, curveLength, freeEnds, faces: faces.length, edges: seen.size };
}

const close = (found, expected, tolerance, what) =>
  assert.ok(Math.abs(found - expected) <= tolerance, `${what}: the page has ${found}, the program ${expected}`);

// `loops`: curves that never burn have no exits for their duals, which the page then draws a little differently.
const full = process.env.QUENCH_TEST_FULL === "1";
const shapes = [
  { name: "fin-on-board", resolution: 32, full: 48 },
  { name: "ellipsoid", resolution: 40, options: ["--lambda", "auto"] },
  { name: "root", resolution: 64, sample: ["--branches", "6", "--fineness", "1"] },
  { name: "four-blobs", resolution: 32, full: 48 },
  { name: "torus", resolution: 28, full: 40, loops: true },
  { name: "plate-with-holes", resolution: 40, full: 48, loops: true },
  { name: "fin-on-board", resolution: 32, full: 48, options: ["--max-triangles", full ? "6000" : "2500"] },
];

let failure = null, browser;
let compared = 0;
try {
  browser = await launcher.launch({
    executablePath: browserFile,
    headless: true,
    args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
      "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-gpu-compositing"],
  });
  for (const [index, shape] of shapes.entries()) {
    const resolution = String((full && shape.full) || shape.resolution);
    const file = `${shape.name}-${index}.ply`, result = `result-${index}`;
    run("sample", shape.name, ...(shape.sample ?? ["--fineness", full ? "1" : "0.25"]), "-o", file);
    run("run", file, "--resolution", resolution, "-o", result, ...(shape.options ?? []));
    const page = await browser.newPage({ viewport: { width: 80, height: 60 } });
    const complaints = [];
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("request", (request) => { if (!/^(file|data|blob):/.test(request.url())) complaints.push(`asks the network: ${request.url()}`); });
    await page.goto(pathToFileURL(join(folder, result, "view.html")).href);
    await page.waitForFunction(() => window.quench.ready || window.quench.error, null, { timeout: 120000 });
    assert.equal(await page.evaluate(() => window.quench.error), null);
    const meta = JSON.parse(await page.evaluate(() => document.getElementById("quench-meta").textContent));
    const sets = (states) => page.evaluate((all) => all.map((s) => { window.quench.set(s); return { ...window.quench.sets(), state: window.quench.state }; }), states);
    const side = meta.side;
    const text = (x) => (Number.isFinite(x) ? `${x}abs` : "inf");

    // The page opens with the skeleton of the files: the same polygons and length of curves as the graph.
    const [first] = await sets([{}]);
    const csv = readFileSync(join(folder, result, "branches.csv"), "utf8").trim().split("\n").map((row) => row.split(","));
    const column = csv[0].indexOf("length"), length = csv.slice(1).reduce((sum, row) => sum + Number(row[column]), 0);
    run("convert", `${result}/skeleton.vtp`, "s.obj", "--overwrite");
    const written = measure("s.obj");
    assert.equal(first.faces, written.faces, `${shape.name}: faces of the skeleton asked for`);
    close(first.area, written.area, 1e-5 * written.area, `${shape.name}: area of the skeleton asked for`);
    close(first.curveLength, length, 1e-5 * length, `${shape.name}: curves of the skeleton asked for`);
    assert.deepEqual([first.state.theta2, first.state.theta1], [meta.theta2 ?? Infinity, meta.theta1 ?? Infinity].map(Math.fround));

    const thetas = [[0, 0], [0.005, 0.005], [0.02, 0.01], [0.05, 0.02], [0.1, 0.05], [Infinity, 0.02], [Infinity, 0.1], [Infinity, Infinity]]
      .map(([wish2, wish1]) => ({ layer: "skeleton", theta2: Math.max(Math.fround(wish2 * side), meta.floor.theta2), theta1: Math.max(Math.fround(wish1 * side), meta.floor.theta1) }));
    for (const [i, found] of (await sets(thetas)).entries()) {
      const { theta2, theta1 } = thetas[i];
      assert.equal(found.state.theta2, theta2);
      run("skeleton", `${result}/core.vtp`, "--theta2", text(theta2), "--theta1", text(theta1), "--full", "--tips", "pruned", "--smooth", "0", "-o", "s.obj", "--overwrite");
      const expected = measure("s.obj"), what = `${shape.name} theta2 ${theta2} theta1 ${theta1}`;
      // Region duals lie on their exits, but where the program keeps a part of a sheet from being pressed flat: where
      // polygons are cut, places differ, and with them areas and lengths a little. The cells are the same (page_test).
      close(found.area, expected.area, theta2 === 0 ? 1e-3 * expected.area : 0.04 * expected.area + 4 * meta.voxel * meta.voxel, `${what}: area`);
      close(found.curveLength, expected.curveLength, (Number.isFinite(theta2) ? 0.4 : shape.loops ? 0.02 : 0.003) * expected.curveLength + 2 * meta.voxel, `${what}: curves`);
      // What is left of a tree may be one edge that is of length zero in the page.
      // Among a hundred ends of noise pieces of curves that are cut off with sheets may differ.
      if (expected.curveLength > 2 * meta.voxel) close(found.freeEnds, expected.freeEnds, Number.isFinite(theta2) ? 0.05 * expected.freeEnds : 0, `${what}: free ends`);
      ++compared;
    }

    // The core: the same cells, so the same numbers.
    const [{ name: by, floor }] = meta.measures;
    assert.deepEqual([meta.measures.length, by], [1, meta.pruning.measure]);
    // The smallest threshold is that of the pruning, rounded down, or a floor of the page.
    const isPruning = floor <= meta.pruning.threshold;
    const thresholds = [0, 1.2, 2, 2.5, 5, 1000].map((wish) => ({ layer: "core", threshold: Math.max(Math.fround(wish * meta.voxel), floor) }));
    for (const [i, found] of (await sets(thresholds)).entries()) {
      const { threshold } = thresholds[i];
      run("core", file, "--resolution", resolution, `--${by}`, text(threshold === floor && isPruning ? meta.pruning.threshold : threshold), "-o", "c.obj", "--overwrite");
      const expected = measure("c.obj"), what = `${shape.name} ${by} ${threshold}`;
      assert.equal(found.faces, expected.faces, `${what}: faces`);
      assert.equal(found.edges, expected.edges, `${what}: edges`);
      // Places are rounded to 16 bits of the box.
      close(found.area, expected.area, 1e-3 * expected.area, `${what}: area`);
      close(found.curveLength, expected.curveLength, 1e-3 * expected.curveLength, `${what}: curves`);
      ++compared;
    }
    assert.deepEqual(complaints, []);
    await page.close();
  }
} catch (error) {
  failure = error;
} finally {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
}
if (failure) {
  console.error(failure.message ?? failure);
  process.exit(1);
}
console.log(`${compared} sets of ${shapes.length} results are the program's`);
