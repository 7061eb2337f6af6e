// SPDX-License-Identifier: Apache-2.0
// The sets of the page against repeated removal on small random complexes.
import assert from "node:assert/strict";
import { test } from "node:test";
import { moduleOf } from "./bundle.mjs";
import { boxCore, boxSkeleton, elements, layerArrays, otherLevels, randomCells } from "./fixture.mjs";

const { LayerSets, shareBelow } = await moduleOf("src/sets.ts");
const data = await moduleOf("src/data.ts");

function pageOf(arrays, more = {}) {
  const html = elements({ side: 1, low: [0, 0, 0], high: [1, 1, 1], ...more }, arrays);
  const [meta, base64] = [...html.matchAll(/<script[^>]*>([^<]*)</g)].map((m) => m[1]);
  const document = { getElementById: (id) => ({ textContent: id === "quench-meta" ? meta : base64 }) };
  return data.readPage(document);
}
const layerOf = (name, cells) => pageOf(layerArrays(name, cells)).then((page) => page.layers.get(name));

/// The definition, word by word.
function bruteForce(layer, level, theta1) {
  const curve = new Map();
  layer.curveEdges?.forEach((e, i) => curve.set(e, layer.curveThickness[i]));
  const faces = new Set(), edges = new Set(), vertices = new Set();
  for (let f = 0; f < layer.faceCount; ++f) if ((layer.faceLevel?.[f] ?? Infinity) >= level) faces.add(f);
  for (let e = 0; e < layer.edgeCount; ++e) if (curve.has(e) || (layer.edgeLevel?.[e] ?? Infinity) >= level) edges.add(e);
  for (let v = 0; v < layer.vertexCount; ++v) if ((layer.vertexLevel?.[v] ?? Infinity) >= level) vertices.add(v);
  for (const e of curve.keys()) for (const v of layer.edges.subarray(2 * e, 2 * e + 2)) vertices.add(v);
  const around = (e) => [...faces].filter((f) => layer.sides.subarray(layer.offsets[f], layer.offsets[f + 1]).includes(e)).length;
  const edgesAt = (v) => [...edges].filter((e) => layer.edges[2 * e] === v || layer.edges[2 * e + 1] === v);
  const medial = new Set(layer.medialPoints ?? []);
  for (let again = true; again; ) {
    again = false;
    for (const e of [...edges].reverse()) {
      if (!curve.has(e) || curve.get(e) >= theta1 || around(e) > 0) continue;
      const free = [...layer.edges.subarray(2 * e, 2 * e + 2)].find((v) => edgesAt(v).length === 1 && !medial.has(v));
      if (free === undefined) continue;
      edges.delete(e);
      vertices.delete(free);
      again = true;
    }
  }
  const length = (e) => Math.hypot(...[0, 1, 2].map((k) => layer.points[3 * layer.edges[2 * e] + k] - layer.points[3 * layer.edges[2 * e + 1] + k]));
  const classes = { curves: [], boundary: [], seams: [] };
  for (const e of edges) {
    const n = around(e);
    if (n === 0) classes.curves.push(e);
    else if (n === 1) classes.boundary.push(e);
    else if (n >= 3) classes.seams.push(e);
  }
  return {
    faces: faces.size, edges: edges.size, vertices: vertices.size, ...classes, visible: vertices,
    curveLength: classes.curves.reduce((sum, e) => sum + length(e), 0),
    freeEnds: [...vertices].filter((v) => edgesAt(v).length === 1).length,
    isolated: [...vertices].filter((v) => edgesAt(v).length === 0).length,
  };
}

function compare(layer, sets, level, theta1, where) {
  const set = sets.compute(level, theta1), wanted = bruteForce(layer, level, theta1);
  for (const key of ["faces", "edges", "freeEnds"]) assert.equal(set[key], wanted[key], `${key} ${where}`);
  assert.equal(set.vertices, wanted.vertices, `vertices ${where}`);
  assert.equal(set.isolated.count, wanted.isolated, `isolated ${where}`);
  assert.ok(Math.abs(set.curves.length - wanted.curveLength) < 1e-5, `length ${where}`);
  for (const key of ["boundary", "seams"])
    assert.deepEqual([...set[key].edge.subarray(0, set[key].count)].sort((a, b) => a - b), wanted[key].sort((a, b) => a - b), `${key} ${where}`);
  // Of an isolated edge either end may stay, so curves are compared as edges.
  assert.deepEqual([...set.curves.edge.subarray(0, set.curves.count)].sort((a, b) => a - b), wanted.curves.sort((a, b) => a - b), `curves ${where}`);
  let visible = 0;
  for (let v = 0; v < layer.vertexCount; ++v) visible += Number(sets.isVisible(v));
  assert.equal(visible, wanted.vertices, `visible ${where}`);
}

const LEVELS = [-1, 0, 0.25, 0.3, 0.75, 1, 1.25, 2, Infinity];

test("skeletons of random complexes are those of repeated removal", async () => {
  for (let seed = 1; seed <= 400; ++seed) {
    const layer = await layerOf("family", randomCells(seed, true)), sets = new LayerSets(layer);
    // Up and down: nothing may be left over from the set before.
    for (const level of [...LEVELS, 0.5, 0]) for (const theta1 of [Infinity, 0, 0.6, 1.25]) compare(layer, sets, level, theta1, `seed ${seed}, ${level}, ${theta1}`);
  }
});

test("cores of random complexes are the cells of enough level", async () => {
  for (let seed = 1000; seed < 1300; ++seed) {
    const layer = await layerOf("core", randomCells(seed, false)), sets = new LayerSets(layer);
    for (const level of [...LEVELS, 0.5, 0]) compare(layer, sets, level, 0, `seed ${seed}, ${level}`);
  }
});

test("cores by another measure of the page", async () => {
  for (let seed = 2000; seed < 2100; ++seed) {
    const arrays = layerArrays("core", randomCells(seed, false));
    Object.assign(arrays, otherLevels(arrays, "size", (v) => ((7 * v) % 5) / 4));
    const page = await pageOf(arrays, { measures: [{ name: "lambda", floor: 0 }, { name: "size", floor: 0.25 }] });
    assert.deepEqual(page.meta.measures[1], { name: "size", floor: 0.25 });
    const core = page.layers.get("core"), layer = data.byMeasure(core, "size"), sets = new LayerSets(layer);
    assert.equal(data.byMeasure(core, "lambda"), core);
    for (const level of [...LEVELS, 0.5, 0]) compare(layer, sets, level, 0, `seed ${seed}, ${level}`);
    const cycles = (l) => Array.from({ length: l.faceCount }, (_, f) => [...l.corners.subarray(l.offsets[f], l.offsets[f + 1]), ...l.sides.subarray(l.offsets[f], l.offsets[f + 1])].join(" ")).sort();
    assert.deepEqual(cycles(layer), cycles(core));
  }
});

test("a complex without levels is always whole", async () => {
  const layer = await layerOf("still", randomCells(7, false)), sets = new LayerSets(layer);
  const set = sets.compute(0, 0);
  assert.equal(set.faces, layer.faceCount);
  assert.equal(set.vertices, layer.vertexCount);
  compare(layer, sets, 0, 0, "still");
});

test("the box: figures known by hand", async () => {
  const core = new LayerSets(await layerOf("core", boxCore()));
  let set = core.compute(0, 0);
  assert.deepEqual([set.faces, set.triangles, set.edges, set.vertices], [12, 16, 21, 10]);
  assert.equal(set.seams.count, 9); // the ridge and the eight edges to the corners
  set = core.compute(0.6, 0);
  assert.deepEqual([set.faces, set.seams.count], [8, 5]);
  set = core.compute(1, 0);
  assert.deepEqual([set.faces, set.seams.count, set.boundary.count], [4, 1, 12]);
  assert.ok(Math.abs(set.area - 4 * 3 * Math.SQRT2) < 1e-5); // trapezia with sides 4 and 2
  const skeleton = new LayerSets(await layerOf("family", boxSkeleton()));
  set = skeleton.compute(0, 0);
  assert.deepEqual([set.faces, set.curves.count, set.freeEnds, set.isolated.count], [1, 8, 4, 0]);
  set = skeleton.compute(0, 0.3); // the two twigs go, and the short edge to its medial point
  assert.deepEqual([set.curves.count, set.freeEnds, set.isolated.count], [5, 1, 1]);
  set = skeleton.compute(1, 0); // the sheet turns into the curve at its side
  assert.deepEqual([set.faces, set.curves.count, set.boundary.count], [0, 9, 0]);
  set = skeleton.compute(Infinity, Infinity); // the loop, the medial point, and one vertex of the tree
  assert.deepEqual([set.curves.count, set.isolated.count, set.freeEnds], [3, 2, 0]);
});

test("the share of a triangle below a level, against samples", () => {
  for (const [a, b, c] of [[0, 1, 2], [2, 0, 1], [1, 1, 2], [0, 0, 1], [0, 1, 1], [3, 3, 3]])
    for (const level of [-1, 0, 0.3, 1, 1.5, 2, 2.9, 4]) {
      let below = 0, all = 0;
      const n = 300;
      for (let i = 0; i < n; ++i)
        for (let j = 0; i + j < n; ++j) {
          const u = (i + 1 / 3) / n, v = (j + 1 / 3) / n;
          below += Number(a + u * (b - a) + v * (c - a) < level);
          ++all;
        }
      assert.ok(Math.abs(shareBelow(a, b, c, level) - below / all) < 0.01, `${[a, b, c]} at ${level}`);
    }
});
