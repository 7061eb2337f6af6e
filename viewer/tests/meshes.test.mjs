// SPDX-License-Identifier: Apache-2.0
// Medial meshes of any number of vertices against a simple reckoning, and their slabs.
import assert from "node:assert/strict";
import { test } from "node:test";
import { moduleOf } from "./bundle.mjs";
import { random } from "./fixture.mjs";

const { Collapses } = await moduleOf("src/collapses.ts");
const { slabsOf } = await moduleOf("src/slabs.ts");

/// A random complex with random steps; some of them only move a vertex.
function randomMeshes(seed) {
  const next = random(seed), count = 3 + Math.floor(next() * 10), pick = (n) => Math.floor(next() * n);
  const coordinates = (n) => Float32Array.from({ length: n }, () => next());
  const triangles = [], edges = [];
  for (let t = pick(12); t > 0; --t) {
    const corners = [...new Set([pick(count), pick(count), pick(count)])];
    if (corners.length === 3) triangles.push(...corners);
  }
  const sides = new Set();
  for (let t = 0; t < triangles.length; t += 3) for (const [a, b] of [[0, 1], [1, 2], [0, 2]]) sides.add([triangles[t + a], triangles[t + b]].sort((x, y) => x - y).join());
  for (let e = pick(8); e > 0; --e) {
    const ends = [...new Set([pick(count), pick(count)])].sort((x, y) => x - y);
    if (ends.length === 2 && !sides.has(ends.join())) edges.push(...ends);
  }
  const left = Array.from({ length: count }, (_, v) => v), steps = [];
  for (let s = pick(2 * count); s > 0 && left.length > 1; --s) {
    const kept = left[pick(left.length)];
    if (next() < 0.3) steps.push(kept, kept);
    else {
      const others = left.filter((v) => v !== kept), removed = others[pick(others.length)];
      left.splice(left.indexOf(removed), 1);
      steps.push(kept, removed);
    }
  }
  return { points: coordinates(3 * count), radius: coordinates(count), triangles: Uint32Array.from(triangles), edges: Uint32Array.from(edges), steps: Uint32Array.from(steps), stepPoints: coordinates(1.5 * steps.length), stepRadius: coordinates(steps.length / 2), errors: null };
}

/// The mesh of `wanted` vertices, step by step: places and radii in order, cells as sets of these numbers.
function reckoned(data, wanted) {
  let cells = [];
  const points = [...data.points], radius = [...data.radius], there = new Set(data.radius.keys());
  for (const v of there) cells.push([v]);
  for (let t = 0; t < data.triangles.length; t += 3) {
    const [a, b, c] = data.triangles.slice(t, t + 3);
    cells.push([a, b, c], [a, b], [b, c], [a, c]);
  }
  for (let e = 0; e < data.edges.length; e += 2) cells.push([...data.edges.slice(e, e + 2)]);
  for (let s = 0; 2 * s < data.steps.length; ++s) {
    const kept = data.steps[2 * s], removed = data.steps[2 * s + 1];
    if (kept !== removed) {
      if (there.size === wanted) break;
      there.delete(removed);
      cells = cells.map((cell) => cell.map((v) => (v === removed ? kept : v)));
    }
    for (let k = 0; k < 3; ++k) points[3 * kept + k] = data.stepPoints[3 * s + k];
    radius[kept] = data.stepRadius[s];
  }
  const order = [...there].sort((a, b) => a - b), row = new Map(order.map((v, i) => [v, i]));
  const sets = new Set(cells.map((cell) => [...new Set(cell.map((v) => row.get(v)))].sort((a, b) => a - b).join()));
  return { points: order.flatMap((v) => points.slice(3 * v, 3 * v + 3)), radius: order.map((v) => radius[v]), cells: [...sets].sort() };
}

const cellsOf = (layer) => {
  const sets = new Set(Array.from({ length: layer.vertexCount }, (_, v) => String(v)));
  for (let e = 0; e < layer.edgeCount; ++e) sets.add([layer.edges[2 * e], layer.edges[2 * e + 1]].sort((a, b) => a - b).join());
  for (let f = 0; f < layer.faceCount; ++f) sets.add([...layer.corners.slice(3 * f, 3 * f + 3)].sort((a, b) => a - b).join());
  return [...sets].sort();
};

test("the mesh of every number of vertices is what the steps leave", () => {
  for (let seed = 1; seed <= 1500; ++seed) {
    const data = randomMeshes(seed), meshes = new Collapses(data), removed = Array.from({ length: data.steps.length / 2 }, (_, s) => Number(data.steps[2 * s] !== data.steps[2 * s + 1])).reduce((a, b) => a + b, 0);
    assert.deepEqual([meshes.most, meshes.least], [data.radius.length, data.radius.length - removed]);
    for (let n = meshes.least; n <= meshes.most; ++n) {
      const layer = meshes.at(n), wanted = reckoned(data, n);
      assert.deepEqual([...layer.points], wanted.points, `seed ${seed}, ${n}`);
      assert.deepEqual([...layer.measures.get("radius")], wanted.radius);
      assert.deepEqual(cellsOf(layer), wanted.cells, `seed ${seed}, ${n}`);
      assert.equal(layer.edgeCount + layer.faceCount + layer.vertexCount, wanted.cells.length); // each once
    }
  }
});

test("numbers that are not there become the nearest that are; errors lie on lines in logarithms", () => {
  const data = { ...randomMeshes(7), errors: Float32Array.from([16, 0.25, 1, 2, 4, 1, 4, 8]) }, meshes = new Collapses(data);
  assert.deepEqual([0, 1e9, NaN, meshes.least + 0.4].map((n) => meshes.clamp(n)), [meshes.least, meshes.most, meshes.most, meshes.least]);
  assert.deepEqual(meshes.error(16), { mean: 0.25, most99: 1, largest: 2, exact: true });
  const between = meshes.error(8);
  assert.ok(Math.abs(between.mean - 0.5) < 1e-6 && Math.abs(between.largest - 4) < 1e-6 && !between.exact);
  assert.equal(meshes.error(17), null);
  assert.equal(meshes.error(3), null);
});

test("what does not fit together is refused", () => {
  const good = { points: new Float32Array(9), radius: new Float32Array(3), triangles: Uint32Array.from([0, 1, 2]), edges: new Uint32Array(0), steps: Uint32Array.from([0, 1, 0, 2]), stepPoints: new Float32Array(6), stepRadius: new Float32Array(2), errors: null };
  new Collapses(good);
  for (const change of [{ radius: new Float32Array(2) }, { triangles: Uint32Array.from([0, 1, 3]) }, { edges: Uint32Array.from([0]) }, { edges: Uint32Array.from([0, 9]) }, { steps: Uint32Array.from([0, 1, 1, 2]) }, { steps: Uint32Array.from([0, 1, 2, 1]) }, { steps: Uint32Array.from([0, 1]) }, { stepRadius: new Float32Array(3) }, { points: Float32Array.from({ length: 9 }, () => NaN) }, { errors: new Float32Array(3) }])
    assert.throws(() => new Collapses({ ...good, ...change }), /do not fit together/);
});

test("slabs touch the balls of their corners, and no ball sticks out", () => {
  for (let seed = 1; seed <= 300; ++seed) {
    const next = random(seed), places = Float32Array.from({ length: 12 }, (_, i) => (i % 4 === 3 ? 0.4 * next() : next()));
    const layer = { faceCount: 1, corners: Uint32Array.from([0, 1, 2]) }, { place, normal, corner } = slabsOf(layer, places);
    if (place.length === 0) continue; // one ball lies in what the others span
    assert.deepEqual([...corner], [0, 1, 2, 0, 1, 2]);
    for (let i = 0; i < 6; ++i) {
      const n = normal.slice(3 * i, 3 * i + 3), p = place.slice(3 * i, 3 * i + 3), off = (v) => n.reduce((sum, x, k) => sum + x * (places[4 * v + k] - p[k]), 0) + places[4 * v + 3];
      assert.ok(Math.abs(Math.hypot(...n) - 1) < 1e-5);
      for (let v = 0; v < 3; ++v) assert.ok(Math.abs(off(v)) < 1e-5, `${off(v)}`); // in the plane that touches all three
    }
  }
});
