// SPDX-License-Identifier: Apache-2.0
// Numbers, addresses, commands, scales: what has no picture.
import assert from "node:assert/strict";
import { test } from "node:test";
import { moduleOf } from "./bundle.mjs";
import { boxCore, boxShape, boxSkeleton, elements, layerArrays, otherLevels, random, simpleArrays } from "./fixture.mjs";

const format = await moduleOf("src/format.ts");
const { readPage } = await moduleOf("src/data.ts");
const { commandOf } = await moduleOf("src/command.ts");
const states = await moduleOf("src/state.ts");
const { LogScale, histogram } = await moduleOf("src/histogram.ts");

function page(meta = {}, more = {}) {
  const html = elements(meta, { ...layerArrays("core", boxCore()), ...layerArrays("family", boxSkeleton()), ...more });
  const [text, base64] = [...html.matchAll(/<script[^>]*>([^<]*)</g)].map((m) => m[1]);
  return readPage({ getElementById: (id) => ({ textContent: id === "quench-meta" ? text : base64 }) });
}

test("lengths are the largest float32 not above, and short where that is enough", () => {
  const next = random(3);
  for (let i = 0; i < 20000; ++i) {
    const x = (next() - 0.3) * 10 ** Math.floor(next() * 12 - 6), f = format.floor32(x);
    assert.equal(Math.fround(f), f);
    assert.ok(f <= x && x - f <= Math.abs(x) * 2 ** -22 + 1e-40);
    const decimal = Number(format.decimalOf(f, false));
    assert.equal(format.floor32(decimal), f);
    assert.ok(decimal >= f);
    assert.equal(Number(format.decimalOf(f, true)), f);
  }
  assert.equal(format.decimalOf(format.floor32(0.03), false), "0.03");
  assert.equal(format.decimalOf(Infinity, false), "inf");
  assert.equal(format.short(1234.56), "1235");
  assert.equal(format.short(0.000123456), "0.000123");
  assert.equal(format.parseLength(" inf "), Infinity);
  assert.ok(Number.isNaN(format.parseLength("x")));
  assert.deepEqual(format.ticks(0, 1, 5), [0, 0.2, 0.4, 0.6000000000000001, 0.8, 1]);
});

test("the last array may be filled up to four bytes", async () => {
  for (const count of [1, 2, 3]) {
    const sites = Array.from({ length: 3 * count }, (_, i) => i);
    const p = await page({}, { "shape/sites": ["u16", 3, sites] });
    assert.deepEqual([...p.shape.sites], sites);
  }
});

test("a page of many shapes gives the command that made it", async () => {
  const p = await page({ files: {}, command: "quench run waters.geojson -o waters" }), state = states.defaults(p, false);
  assert.equal(commandOf(p, { ...state, layer: "skeleton" }), "quench run waters.geojson -o waters");
});

test("the address holds the view", async () => {
  const p = await page({ theta2: null, theta1: 0.4 }), base = states.defaults(p, false);
  assert.deepEqual([base.theta2, base.color, base.curvesByMeasure], [Infinity, "radius", true]); // pure curves carry the colours
  const state = states.sanitize({ ...base, layer: "core", threshold: 0.3, color: "radius", theta2: 0.7, balls: true, dark: true, ui: false, clipAt: 0.25 }, p);
  const camera = { position: [1, 2, 3.5], target: [0, 0, 1], up: [0, 1, 0] };
  const back = states.fromHash(`#${states.toHash(state, base, camera)}`, base);
  assert.deepEqual(back, { state, camera });
  assert.equal(states.toHash(base, base, null), "");
  const odd = states.fromHash("#theta2=soup&layer=7&color=%00&camera=1,2&nothing=1&threshold=-4", base);
  assert.equal(odd.camera, null);
  assert.deepEqual(states.sanitize(odd.state, p), { ...base, color: "erosion_thickness" });
});

test("the address says by which measure and how far the core is pruned", async () => {
  const levels = { ...layerArrays("core", boxCore()), ...layerArrays("family", boxSkeleton()) };
  const measures = [{ name: "lambda", floor: 0.25 }, { name: "detail", floor: 0.5 }], pruning = { measure: "detail", threshold: 0.75 };
  const p = await page({ measures, pruning }, otherLevels(levels, "detail", (v) => v / 4));
  const base = states.defaults(p, false);
  const at = (hash) => { const s = states.sanitize(states.fromHash(hash, base).state, p); return [s.measure, s.threshold]; };
  assert.deepEqual([base.measure, base.threshold], ["detail", 0.75]);
  assert.deepEqual(at(""), ["detail", 0.75]);
  assert.deepEqual(at("threshold=1.5"), ["detail", 1.5]);
  assert.deepEqual(at("threshold=0.125"), ["detail", 0.5]); // no less than the floor
  assert.deepEqual(at("measure=lambda"), ["lambda", 0.25]); // a threshold belongs to its measure
  assert.deepEqual(at("measure=lambda&threshold=0.75"), ["lambda", 0.75]);
  assert.deepEqual(at("measure=size&threshold=4"), ["detail", 0.75]);
  for (const old of ["lambda=1.25", "lambda=1.25&measure=lambda", "layer=core&lambda=1.25&threshold=7"]) assert.deepEqual(at(old), ["lambda", 1.25], old);
  assert.deepEqual(at("lambda=1.25&measure=detail&threshold=1"), ["detail", 1]);
  for (const change of [{}, { threshold: 0.5 }, { measure: "lambda", threshold: 0.75 }, { measure: "lambda", threshold: 0.25 }]) {
    const state = { ...base, ...change };
    assert.deepEqual(at(states.toHash(state, base, null)), [state.measure, state.threshold]);
  }
  const byLambda = states.defaults(await page({ pruning: { measure: "lambda", threshold: null } }), false);
  assert.deepEqual([byLambda.measure, byLambda.threshold], ["lambda", Infinity]);
  // Of a layer without the measure that was pruned by, and without a core.
  const other = states.defaults(await page({ pruning, measures: [{ name: "lambda", floor: 0.25 }] }), false);
  assert.deepEqual([other.measure, other.threshold], ["lambda", 0.25]);
});

test("the command line writes what is seen", async () => {
  const p = await page({ command: "quench run 'my box.nrrd' --threshold 20 --resolution=64 --invert --lambda 0.02 -o x", files: { core: "x/core.vtp", shape: "my box.nrrd" }, pruning: { measure: "lambda", threshold: 0.5 } });
  const base = states.defaults(p, false);
  const at = (change) => commandOf(p, states.sanitize({ ...base, ...change }, p));
  assert.equal(at({ theta2: 0.25, theta1: Infinity }), "quench skeleton x/core.vtp --theta2 0.25abs --theta1 inf --tips pruned -o skeleton.vtp");
  assert.equal(at({ theta2: 0.6, theta1: 0 }), `quench skeleton x/core.vtp --theta2 0.6abs --theta1 0 --tips pruned -o skeleton.vtp`);
  assert.equal(at({ layer: "core", threshold: 0.26 }), "quench core 'my box.nrrd' --threshold 20 --resolution=64 --invert --lambda 0.26abs -o core.vtp");
  const byDetail = await page({ measures: [{ name: "detail", floor: 0.1 }], command: "quench run box.off --detail 2vox -o x" });
  assert.equal(commandOf(byDetail, { ...states.defaults(byDetail, false), layer: "core" }), "quench core box.off --detail 0.1abs -o core.vtp");
  const exact = 0.036084391824351615; // no float32
  const start = await page({ measures: [{ name: "detail", floor: format.floor32(exact) }], pruning: { measure: "detail", threshold: exact } });
  assert.equal(commandOf(start, { ...states.defaults(start, false), layer: "core" }), `quench core box.off --detail ${exact}abs -o core.vtp`);
  const byAngle = await page({ measures: [{ name: "object_angle", floor: 0 }] });
  assert.equal(commandOf(byAngle, { ...states.defaults(byAngle, false), layer: "core" }), "");
});

test("the outline of triangles goes around them", async () => {
  const { outlineOf } = await moduleOf("src/scene/outline.ts");
  const sides = (triangles) => {
    const list = outlineOf(Uint32Array.from(triangles), 9);
    return Array.from({ length: list.length / 2 }, (_, i) => `${list[2 * i]}${list[2 * i + 1]}`).sort();
  };
  assert.deepEqual(sides([0, 1, 2, 0, 2, 3]), ["01", "12", "23", "30"]);
  assert.deepEqual(sides([0, 1, 2, 2, 1, 0]), []);
  assert.deepEqual(sides([0, 1, 2, 0, 1, 2]), ["01", "01", "12", "12", "20", "20"]);
});

test("a logarithmic scale goes there and back", () => {
  const scale = new LogScale(0.1, 10, 0.01);
  for (const x of [0.1, 0.5, 1, 9.9, 10]) assert.ok(Math.abs(scale.value(scale.position(x), true) - x) < 1e-9);
  assert.equal(scale.value(1, true), Infinity);
  assert.equal(scale.value(1, false), 10);
  assert.equal(scale.position(Infinity), 1);
  const bins = histogram(scale, [0.1, 10, Infinity, NaN], () => 2, 10);
  assert.equal(bins.reduce((a, b) => a + b), 6);
});

test("the command of a medial mesh and of a thickness; an address with a colour of the surface means an opaque one", async () => {
  const shape = boxShape(), p = await page({ command: "quench run box.off --resolution 128 -o box" }, { ...shape.arrays, ...simpleArrays(), "shape/point/thickness": ["f32", 1, [1, 1, 1, 1, 1, 1, 1, 2]] }), base = states.defaults(p, false);
  const with_ = (change) => states.sanitize({ ...base, ...change }, p);
  assert.equal(commandOf(p, with_({ layer: "simple", vertices: 4 })), "quench simplify core.vtp --vertices 4 --shape box.off -o mesh.vtp");
  assert.equal(commandOf(p, with_({ surface: "thickness", shapeOpacity: 1 })), "quench thickness box.off --resolution 128 --surface thickness.ply");
  for (const shapeOpacity of [1, 0.5]) {
    const state = with_({ surface: "thickness", shapeOpacity });
    assert.deepEqual(states.fromHash(states.toHash(state, base, null), base).state, state);
  }
  assert.deepEqual([states.fromHash("surface=thickness", base).state.shapeOpacity, base.shapeOpacity], [1, 0.5]);
  assert.equal(states.layerOf(p, with_({ layer: "simple", vertices: 3 })).vertexCount, 3);
});
