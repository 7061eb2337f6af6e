// SPDX-License-Identifier: Apache-2.0
// Pages in the format of FORMAT.md for tests: small complexes made by hand, and random ones.
import { gzipSync } from "node:zlib";

const BYTES = { f32: 4, u32: 4, u16: 2, u8: 1 };
const ARRAYS = { f32: Float32Array, u32: Uint32Array, u16: Uint16Array, u8: Uint8Array };

/// arrays: { name: [type, components, numbers] }
export function pack(arrays) {
  const entries = [], pieces = [];
  let offset = 0;
  for (const [name, [type, components, numbers]] of Object.entries(arrays)) {
    const bytes = Buffer.from(ARRAYS[type].from(numbers).buffer);
    entries.push({ name, type, components, count: numbers.length / components, offset });
    const padding = Buffer.alloc((4 - (bytes.length % 4)) % 4);
    pieces.push(bytes, padding);
    offset += numbers.length * BYTES[type] + padding.length;
  }
  return { entries, bytes: Buffer.concat(pieces) };
}

/// The two elements; `damage` may change what goes into them.
export function elements(meta, arrays, damage = {}) {
  const { entries, bytes } = pack(arrays);
  const whole = { format: 2, title: "test", program: "quench test", command: "quench run box.off -o box", unit: "mm", side: 4, voxel: 0.25, low: [0, 0, 0], high: [4, 2, 2], floor: { theta2: 0, theta1: 0 }, measures: [{ name: "lambda", floor: 0 }], notes: [], files: { core: "core.vtp", skeleton: "skeleton.vtp", shape: "box.off" }, ...meta, arrays: entries };
  const json = JSON.stringify(damage.meta ? damage.meta(whole) : whole).replaceAll("<", "\\u003c");
  const zipped = gzipSync(bytes);
  const data = damage.data ? damage.data(zipped) : zipped.toString("base64");
  return `<script type="application/json" id="quench-meta">${json}</script>\n<script type="application/octet-stream" id="quench-data">${data}</script>`;
}

export function pageOf(template, meta, arrays, damage) {
  return template.replace("<!--quench-data-->", () => elements(meta, arrays, damage));
}

/// Levels of the core by another measure: of every cell that of its last vertex, and of an edge the largest of its faces
/// as well, of a vertex of its edges.
export function otherLevels(arrays, measure, ofVertex) {
  const edges = arrays["core/edges"][2], corners = arrays["core/polygon_corners"][2], sides = arrays["core/polygon_edges"][2], offsets = arrays["core/polygon_offsets"][2];
  const face = [], edge = [], vertex = arrays["core/vertex_level"][2].map((_, v) => ofVertex(v));
  for (let e = 0; e < edges.length / 2; ++e) edge.push(ofVertex(edges[2 * e + 1]));
  for (let f = 0; f + 1 < offsets.length; ++f) {
    face.push(ofVertex(corners[offsets[f + 1] - 1]));
    for (let i = offsets[f]; i < offsets[f + 1]; ++i) edge[sides[i]] = Math.max(edge[sides[i]], face[f]);
  }
  edges.forEach((v, i) => { vertex[v] = Math.max(vertex[v], edge[i >> 1]); });
  return Object.fromEntries(Object.entries({ face, edge, vertex }).map(([of, levels]) => [`core/${of}_level/${measure}`, ["f32", 1, levels]]));
}

/// Arrays of a layer. faces: lists of vertices in decreasing order of level; lone edges beside.
/// cells: { points, faces: [{ corners, level }], lone: [{ ends, level, thickness? }], vertexLevel?, measures }
export function layerArrays(name, cells) {
  const points = cells.points.flat(), edges = [], index = new Map();
  const edgeOf = (a, b) => {
    const key = a < b ? `${a} ${b}` : `${b} ${a}`;
    if (!index.has(key)) {
      index.set(key, edges.length);
      edges.push({ ends: [Math.min(a, b), Math.max(a, b)], level: -Infinity });
    }
    return index.get(key);
  };
  const faces = [...(cells.faces ?? [])].sort((a, b) => b.level - a.level);
  const offsets = [0], corners = [], sides = [];
  for (const { corners: c, level } of faces) {
    c.forEach((v, i) => {
      const e = edgeOf(v, c[(i + 1) % c.length]);
      corners.push(v);
      sides.push(e);
      edges[e].level = Math.max(edges[e].level, level);
    });
    offsets.push(corners.length);
  }
  const curves = [], thickness = [];
  for (const { ends, level, thickness: t } of cells.lone ?? []) {
    const e = edgeOf(...ends);
    edges[e].level = Math.max(edges[e].level, level ?? Infinity);
    if (t !== undefined) {
      curves.push(e);
      thickness.push(t);
    }
  }
  const vertexLevel = cells.points.map((_, v) => cells.vertexLevel?.[v] ?? -Infinity);
  for (const { ends, level } of edges) for (const v of ends) vertexLevel[v] = Math.max(vertexLevel[v], level);
  const arrays = {
    [`${name}/points`]: ["f32", 3, points],
    [`${name}/polygon_offsets`]: ["u32", 1, offsets],
    [`${name}/polygon_corners`]: ["u32", 1, corners],
    [`${name}/polygon_edges`]: ["u32", 1, sides],
    [`${name}/edges`]: ["u32", 2, edges.flatMap((e) => e.ends)],
  };
  if (name !== "still") {
    arrays[`${name}/face_level`] = ["f32", 1, faces.map((f) => f.level)];
    arrays[`${name}/edge_level`] = ["f32", 1, edges.map((e) => e.level)];
    arrays[`${name}/vertex_level`] = ["f32", 1, vertexLevel];
  }
  if (curves.length > 0) {
    arrays[`${name}/curve_edges`] = ["u32", 1, curves];
    arrays[`${name}/curve_thickness`] = ["f32", 1, thickness];
  }
  if (cells.medialPoints) arrays[`${name}/medial_points`] = ["u32", 1, cells.medialPoints];
  for (const [measure, values] of Object.entries(cells.measures ?? {})) arrays[`${name}/point/${measure}`] = ["f32", 1, values];
  return arrays;
}

/// The box [0,4] x [0,2] x [0,2]: a sheet between two ridges, four walls at either end (quadrilaterals and triangles
/// from the ends of the ridge line to the corners). The medial axis of a bar with square section is a line with four
/// wings along it, and eight triangles: 2 x 4 of them at the ends.
export function boxCore() {
  const points = [[1, 1, 1], [3, 1, 1]];
  const low = [], high = [];
  for (const [y, z] of [[0, 0], [2, 0], [2, 2], [0, 2]]) {
    low.push(points.push([0, y, z]) - 1);
    high.push(points.push([4, y, z]) - 1);
  }
  const faces = [];
  for (let k = 0; k < 4; ++k) {
    faces.push({ corners: [0, 1, high[k], low[k]], level: 1 });
    faces.push({ corners: [0, low[k], low[(k + 1) % 4]], level: 0.75 });
    faces.push({ corners: [1, high[k], high[(k + 1) % 4]], level: 0.5 });
  }
  const radius = points.map((_, v) => (v < 2 ? 1 : 0));
  return {
    points, faces,
    measures: { radius, lambda: points.map((_, v) => (v < 2 ? 1 : 0.75)), burn_time: points.map((_, v) => (v < 2 ? 1.7 : 0)), erosion_thickness: points.map((_, v) => (v < 2 ? 0.7 : 0)) },
  };
}

/// A sheet in the middle of the box with a tree of curves at it and a loop apart; a path along x with thickness
/// falling towards its ends.
export function boxSkeleton() {
  const points = [[1.5, 0.5, 1], [2.5, 0.5, 1], [2.5, 1.5, 1], [1.5, 1.5, 1], [1, 1, 1], [0.5, 1, 1], [0.2, 1.4, 1], [0.2, 0.6, 1], [3, 1, 1.4], [3.4, 1, 1.4], [3.2, 1, 1.7], [3.7, 1, 0.4], [3.8, 1, 0.4]];
  return {
    points,
    faces: [{ corners: [0, 1, 2, 3], level: 0.6 }],
    lone: [
      { ends: [0, 3], thickness: 0.9 }, // a side of the sheet that is also a curve
      { ends: [0, 4], thickness: 0.8 }, { ends: [4, 5], thickness: 0.5 }, { ends: [5, 6], thickness: 0.2 }, { ends: [5, 7], thickness: 0.1 },
      { ends: [8, 9], thickness: Infinity }, { ends: [9, 10], thickness: Infinity }, { ends: [8, 10], thickness: Infinity },
      { ends: [11, 12], thickness: 0.05 },
    ],
    medialPoints: [12],
    measures: {
      radius: points.map((p) => 0.4 + 0.1 * p[0]), burn_time: points.map((_, v) => (v > 7 && v < 11 ? Infinity : 0.5 + 0.1 * v)),
      erosion_thickness: points.map((_, v) => 0.05 * v), curve_erosion_thickness: points.map((_, v) => (v === 1 || v === 2 ? NaN : 0.05 * v)),
    },
  };
}

/// The surface of the box, its lattice corners at distance 0.5 and samples.
export function boxShape() {
  const points = [], sites = [], samples = [];
  for (const x of [0, 4]) for (const y of [0, 2]) for (const z of [0, 2]) points.push([x, y, z]);
  const triangles = [[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]];
  for (let z = 0; z <= 4; ++z)
    for (let y = 0; y <= 4; ++y)
      for (let x = 0; x <= 8; ++x) if (x % 8 === 0 || y % 4 === 0 || z % 4 === 0) sites.push(x + 1, y + 1, z + 1);
  for (let z = 0; z < 10; ++z) for (let y = 0; y < 10; ++y) for (let x = 0; x < 20; ++x) samples.push(0.1 + 0.2 * x, 0.1 + 0.2 * y, 0.1 + 0.2 * z);
  return {
    meta: { sites_to_world: [0.5, 0, 0, -0.5, 0, 0.5, 0, -0.5, 0, 0, 0.5, -0.5], topology: { euler: 1, betti: [1, 0, 0] }, pruning: { measure: "lambda", threshold: 0.5 }, theta2: 0.3, theta1: 0.3 },
    arrays: { "shape/points": ["f32", 3, points.flat()], "shape/triangles": ["u32", 3, triangles.flat()], "shape/sites": ["u16", 3, sites], "shape/samples": ["f32", 3, samples] },
  };
}

/// What the box's family is at theta2 = theta1 = 0.3: the sheet, a branch to where the twigs went, a loop and a point.
export function askedArrays() {
  const box = boxSkeleton(), { faces } = box, used = [0, 1, 2, 3, 4, 5, 8, 9, 10, 12], of = (values) => used.map((v) => values[v]);
  const points = of(box.points), measures = Object.fromEntries(Object.entries(box.measures).map(([name, values]) => [name, of(values)]));
  const branches = [[0, 4, 5], [6, 7, 8, 6]], length = (path) => path.slice(1).reduce((sum, v, i) => sum + Math.hypot(...points[v].map((x, k) => x - points[path[i]][k])), 0);
  const offsets = [0, 3, 7], nodes = [0, 5, 6, 9];
  const radii = branches.map((path) => path.map((v) => measures.radius[v]));
  const arrays = {
    "skeleton/points": ["f32", 3, points.flat()],
    "skeleton/polygon_offsets": ["u32", 1, [0, 4]],
    "skeleton/polygon_corners": ["u32", 1, faces[0].corners],
    "skeleton/polygon_sheet": ["u32", 1, [0]],
    "skeleton/polygon_thickness": ["f32", 1, [0.6]],
    "skeleton/branch_offsets": ["u32", 1, offsets],
    "skeleton/branch_points": ["u32", 1, branches.flat()],
    "skeleton/branch/length": ["f32", 1, branches.map(length)],
    "skeleton/branch/mean_radius": ["f32", 1, radii.map((r) => r.reduce((a, b) => a + b) / r.length)],
    "skeleton/branch/min_radius": ["f32", 1, radii.map((r) => Math.min(...r))],
    "skeleton/branch/max_radius": ["f32", 1, radii.map((r) => Math.max(...r))],
    "skeleton/branch/thickness": ["f32", 1, [0.8, Infinity]],
    "skeleton/branch/tortuosity": ["f32", 1, [1.1, Infinity]],
    "skeleton/branch_nodes": ["u32", 2, [0, 1, 2, 2]],
    "skeleton/node_points": ["u32", 1, nodes],
    "skeleton/node_kind": ["u8", 1, [2, 0, 3, 4]],
    "skeleton/isolated": ["u32", 1, [9]],
  };
  for (const [name, values] of Object.entries(measures)) arrays[`skeleton/point/${name}`] = ["f32", 1, values];
  return arrays;
}

export function boxPage(template, damage, change = (arrays) => arrays, asked = false) {
  const shape = boxShape();
  return pageOf(template, { title: "box", ...shape.meta }, change({ ...layerArrays("core", boxCore()), ...layerArrays("family", boxSkeleton()), ...(asked ? askedArrays() : {}), ...shape.arrays }), damage);
}

/// Two squares at a right angle and a branch from the end of their seam, with a table of the two sheets: the second is the larger.
export function twoSheets() {
  const points = [[0, 0, 1], [2, 0, 1], [2, 1, 1], [0, 1, 1], [2, 3, 1], [0, 3, 1], [3, 1, 1], [4, 1, 1]];
  const measures = { radius: points.map((_, v) => 0.2 + 0.05 * v), burn_time: points.map((_, v) => 0.4 + 0.1 * v), erosion_thickness: points.map((_, v) => 0.1 + 0.05 * v) };
  const arrays = {
    "skeleton/points": ["f32", 3, points.flat()],
    "skeleton/polygon_offsets": ["u32", 1, [0, 4, 8]],
    "skeleton/polygon_corners": ["u32", 1, [0, 1, 2, 3, 3, 2, 4, 5]],
    "skeleton/polygon_sheet": ["u32", 1, [0, 1]],
    "skeleton/polygon_thickness": ["f32", 1, [0.2, 0.3]],
    "skeleton/branch_offsets": ["u32", 1, [0, 3]],
    "skeleton/branch_points": ["u32", 1, [2, 6, 7]],
    ...Object.fromEntries(["length", "mean_radius", "min_radius", "max_radius", "thickness", "tortuosity"].map((name, i) => [`skeleton/branch/${name}`, ["f32", 1, [i + 1]]])),
    "skeleton/branch_nodes": ["u32", 2, [0, 1]],
    "skeleton/node_points": ["u32", 1, [2, 7]],
    "skeleton/node_kind": ["u8", 1, [2, 0]],
    "skeleton/isolated": ["u32", 1, []],
    "sheets/sheet": ["f32", 1, [0, 1]],
    "sheets/area": ["f32", 1, [2, 4]],
    "sheets/mean_thickness": ["f32", 1, [0.55, 0.8]],
    "sheets/max_erosion": ["f32", 1, [NaN, Infinity]],
    "sheets/neighbours": ["f32", 1, [1, 0]],
  };
  for (const [name, values] of Object.entries(measures)) arrays[`skeleton/point/${name}`] = ["f32", 1, values];
  const column = (name, unit, more = {}) => ({ table: "sheets", name, unit, meaning: `${name} of it`, ...more });
  return { arrays, columns: [column("sheet", "", { whole: true }), column("area", "mm^2"), column("mean_thickness", "mm"), column("max_erosion", "mm"), column("neighbours", "", { words: ["0", "1"] })] };
}

/// A fan of triangles around the vertex 0 with a path of edges from 4 on, that collapse to one vertex; after the first
/// two steps the kept one moves once more.
export function simpleArrays() {
  const points = [[2, 1, 1], [1, 0.5, 1], [3, 0.5, 1], [3, 1.5, 1], [1, 1.5, 1], [0.6, 1.6, 1], [0.3, 1.7, 1]];
  return {
    "simple/points": ["f32", 3, points.flat()],
    "simple/point/radius": ["f32", 1, points.map((_, v) => 0.5 - 0.05 * v)],
    "simple/triangles": ["u32", 3, [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1]],
    "simple/edges": ["u32", 2, [4, 5, 5, 6]],
    "simple/steps": ["u32", 2, [5, 6, 1, 4, 1, 1, 2, 3, 0, 1, 0, 2, 0, 5]],
    "simple/step_points": ["f32", 3, [0.4, 1.7, 1, 1, 1, 1, 0.9, 1, 1, 3, 1, 1, 1.5, 1, 1, 2, 1, 1, 1.5, 1.2, 1]],
    "simple/step_radius": ["f32", 1, [0.2, 0.4, 0.45, 0.4, 0.5, 0.5, 0.5]],
    "simple/errors": ["f32", 4, [2, 0.2, 0.5, 0.8, 5, 0.05, 0.1, 0.2]],
  };
}

/// The rectangle [0,4] x [0,2] of the plane without its part x > 2, y > 1: an axis of a line and two more
/// ends, corners as sites, samples.
export function planePage(template, y, damage) {
  const points = [[1, 1, 0], [0, 0, 0], [0, 2, 0], [3.5, 0.5, 0], [2, 0.5, 0]], radius = [1, 0, 0, 0.5, 0.5];
  const core = { points, lone: [[0, 1, 0.5], [0, 2, 0.5], [0, 4, 1], [4, 3, 1]].map(([a, b, level]) => ({ ends: [a, b], level })), measures: { radius, burn_time: radius, erosion_thickness: [0, 0, 0, 0, Infinity], mgf: [4, 0, 0, 2, Infinity] } };
  const family = { points, lone: [[0, 1, 0.2], [0, 2, 0.4], [0, 4, 0.9], [4, 3, 0.6]].map(([a, b, thickness]) => ({ ends: [a, b], thickness })), medialPoints: [0], measures: { radius, burn_time: radius, erosion_thickness: radius } };
  const sites = [[0, 0], [2, 0], [4, 0], [4, 1], [2, 1], [2, 2], [0, 2], [0, 1], [1, 0], [1, 2]].flatMap(([a, b]) => [a, b, 0]);
  const samples = [];
  for (let j = 0; j < 20; ++j) for (let i = 0; i < 40; ++i) if (i < 20 || j < 10) samples.push(0.05 + 0.1 * i, 0.05 + 0.1 * j, 0);
  const shape = { "shape/points": ["f32", 3, [0, 0, 0, 2, 0, 0, 4, 0, 0, 4, 1, 0, 2, 1, 0, 0, 1, 0, 2, 2, 0, 0, 2, 0]], "shape/triangles": ["u32", 3, [0, 1, 4, 0, 4, 5, 1, 2, 3, 1, 3, 4, 5, 4, 6, 5, 6, 7]], "shape/sites": ["u16", 3, sites], "shape/samples": ["f32", 3, samples] };
  const meta = { title: "plate", unit: "px", dimension: 2, y_axis: y, voxel: 1, low: [0, 0, 0], high: [4, 2, 0], theta1: 0, topology: { euler: 1, betti: [1, 0, 0] }, sites_to_world: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0] };
  return pageOf(template, meta, { ...layerArrays("core", core), ...layerArrays("family", family), ...shape }, damage);
}

/// Numbers from 0 to 1 that are the same each time.
export function random(seed) {
  let s = seed >>> 0 || 1;
  return () => {
    s = (Math.imul(s, 1664525) + 1013904223) >>> 0;
    return s / 4294967296;
  };
}

/// A random complex with faces of 3 to 5 corners, lone edges and isolated vertices, few distinct levels.
export function randomCells(seed, curves) {
  const next = random(seed), n = 4 + Math.floor(next() * 14), pick = (k) => Math.floor(next() * k);
  const points = Array.from({ length: n }, () => [next(), next(), next()]);
  const level = () => (next() < 0.15 ? Infinity : pick(6) / 4);
  const faces = [];
  for (let f = pick(10); f > 0; --f) {
    const corners = [...new Set(Array.from({ length: 3 + pick(3) }, () => pick(n)))];
    if (corners.length >= 3) faces.push({ corners, level: level() });
  }
  const lone = [], used = new Set();
  for (let e = pick(2 * n); e > 0; --e) {
    const ends = [pick(n), pick(n)];
    const key = [...ends].sort((a, b) => a - b).join(" ");
    if (ends[0] === ends[1] || used.has(key)) continue;
    used.add(key);
    lone.push(curves ? { ends, thickness: level() } : { ends, level: level() });
  }
  const medialPoints = curves ? [...new Set(Array.from({ length: pick(3) }, () => pick(n)))] : undefined;
  const vertexLevel = Object.fromEntries(points.map((_, v) => [v, next() < 0.2 ? level() : -Infinity]));
  return { points, faces, lone, medialPoints, vertexLevel, measures: { radius: points.map(() => next()) } };
}

/// A tree in the plane y = 0, 4 long: a stem of radius 0.2 along z with two axes of level 1 at z = -1 (to +x) and
/// z = -2 (to -x), and one of level 2 on the first; a bridge, a cut, and a part that is left out. `repeat`: so many axes
/// of level 2 more.
export function treePage(template, { damage, repeat = 0, change = (arrays) => arrays, meta = {} } = {}) {
  const branches = [
    { parent: -1, axis: 0, points: [[0, 0, 0], [0, 0, -1]], radius: 0.2 },
    { parent: 0, axis: 0, points: [[0, 0, -1], [0, 0, -2]], radius: 0.2 },
    { parent: 1, axis: 0, points: [[0, 0, -2], [0, 0, -3], [0, 0, -4]], radius: 0.2 },
    { parent: 0, axis: 1, points: [[0, 0, -1], [1, 0, -1]], radius: 0.1 },
    { parent: 3, axis: 1, points: [[1, 0, -1], [2, 0, -1]], radius: 0.1 },
    { parent: 1, axis: 2, points: [[0, 0, -2], [-1, 0, -2]], radius: 0.1 },
    { parent: 3, axis: 3, points: [[1, 0, -1], [1, 0, -2]], radius: 0.05 },
  ];
  for (let i = 0; i < repeat; ++i) branches.push({ parent: 3, axis: 4 + i, points: [[1, 0, -1], [1 + i / repeat, 0.5, -1.5]], radius: 0.01 });
  const none = 2 ** 32 - 1, axes = Math.max(...branches.map((b) => b.axis)) + 1, level = (a) => [0, 1, 1, 2][Math.min(3, a)];
  const length = ({ points }) => points.slice(1).reduce((sum, p, i) => sum + Math.hypot(...p.map((x, k) => x - points[i][k])), 0);
  const axisLength = Array.from({ length: axes }, (_, a) => branches.filter((b) => b.axis === a).reduce((sum, b) => sum + length(b), 0));
  const offsets = [0];
  for (const { points } of branches) offsets.push(offsets.at(-1) + points.length);
  const per = (value) => branches.map(value), perAxis = (value) => Array.from({ length: axes }, (_, a) => value(a));
  const parentOf = (a) => (a === 0 ? none : a < 3 ? 0 : 1);
  const arrays = change({
    "tree/points": ["f32", 3, branches.flatMap((b) => b.points.flat())],
    "tree/point/radius": ["f32", 1, branches.flatMap((b) => b.points.map(() => b.radius))],
    "tree/point/angle_to_down": ["f32", 1, branches.flatMap((b) => b.points.map(() => (b.points[0][0] === b.points.at(-1)[0] ? 0 : 90)))],
    "tree/branch_offsets": ["u32", 1, offsets],
    "tree/bridged": ["u32", 1, [offsets[5]]],
    "tree/branch_parent": ["u32", 1, per((b) => (b.parent < 0 ? none : b.parent))],
    "tree/branch_axis": ["u32", 1, per((b) => b.axis)],
    "tree/branch_order": ["u32", 1, per((b) => Math.min(2, b.axis))],
    "tree/branch_strahler": ["u32", 1, per((b) => (b.axis === 0 ? 2 : 1))],
    "tree/axis_parent": ["u32", 1, perAxis(parentOf)],
    "tree/axis_level": ["u32", 1, perAxis(level)],
    "tree/axis_plant": ["u32", 1, perAxis(() => 0)],
    "tree/edit_points": ["f32", 3, [-0.4, 0, -2, -0.6, 0, -2, 1.9, 0, -1, 1.9, 0, -1, 3, 0, -3, 3, 0, -3.5]],
    "tree/axes/axis": ["f32", 1, perAxis((a) => a)],
    "tree/axes/level": ["f32", 1, perAxis(level)],
    "tree/axes/class": ["f32", 1, perAxis(level)],
    "tree/axes/length": ["f32", 1, axisLength],
    "tree/axes/angle": ["f32", 1, perAxis((a) => (a === 0 ? NaN : 90))],
    "tree/branches/branch": ["f32", 1, per((_, i) => i)],
    "tree/branches/length": ["f32", 1, per(length)],
    "tree/sample/total_length": ["f32", 1, [axisLength.reduce((a, b) => a + b)]],
    "tree/sample/depth": ["f32", 1, [4]],
    "tree/edits/kind": ["f32", 1, [0, 1, 2]],
    "tree/edits/length": ["f32", 1, [0.2, 0.1, 0.5]],
    "tree/edits/cost": ["f32", 1, [3, 7, 1]],
  });
  const column = (table, name, unit = "", more = {}) => ({ table, name, unit, meaning: `${name} of it`, ...more });
  const tree = {
    down: [0, 0, -1], to_eye: [0, -1, 0], up: [0, 0, 1],
    columns: [
      column("axes", "axis", "", { whole: true }), column("axes", "level", "", { whole: true }), column("axes", "class", "", { words: ["stem", "axis of level 1", "axis of level 2"] }), column("axes", "length", "mm"), column("axes", "angle", "degrees"),
      column("branches", "branch", "", { whole: true }), column("branches", "length", "mm"), column("sample", "total_length", "mm"), column("sample", "depth", "mm"),
      column("edits", "kind", "", { words: ["bridge", "cut_touching", "left_out"] }), column("edits", "length", "mm"), column("edits", "cost"),
    ],
  };
  return pageOf(template, { title: "root", side: 4, low: [-1, -0.2, -4], high: [2, 0.2, 0], measures: [], files: { tree: "tree.rsml" }, command: "quench tree root.ply -o root", tree, ...meta }, arrays, damage);
}
