// SPDX-License-Identifier: Apache-2.0
// Reads the two data elements of a page (FORMAT.md). Everything that can be wrong with them becomes a PageError with one
// sentence for the reader.

import { Collapses } from "./collapses";
import { PageError } from "./page_error";
import { columnOf, columnsIn, type Column, type ColumnMeta } from "./table";
import { readTree, type Tree, type TreeMeta } from "./tree";
import { bytesOf, checkEntry, complete, sidesOf, unpack } from "./unpack";

export { PageError } from "./page_error";

export const FORMAT = 2;

/// What can be shown. A skeleton is that which was asked for, or, for other thetas, one of its family; `simple` is a
/// medial mesh of any number of vertices.
export type LayerName = "core" | "skeleton" | "still" | "tree" | "simple";
export type LayerKey = LayerName | "family";
export const LAYER_KEYS: LayerKey[] = ["tree", "skeleton", "family", "core", "simple", "still"];

export type Triple = [number, number, number];

export interface ArrayEntry {
  name: string;
  type: "f32" | "u32" | "u16" | "u8";
  components: number;
  count: number;
  offset: number;
  /// None: the bytes are the values.
  code?: "delta" | "steps" | "fresh" | "again" | "difference";
  planes?: number;
  bits?: number;
  low?: number[];
  step?: number[];
  of?: string[];
}

/// A measure by which the layer `core` can be pruned, and the threshold from which on it is complete.
export interface PruningMeasure { name: string; floor: number }

export interface Meta {
  format: number;
  title: string;
  program: string;
  command: string;
  unit: string;
  side: number;
  voxel?: number;
  low: Triple;
  high: Triple;
  origin: Triple;
  /// Of the axis that was burned.
  pruning?: { measure: string; threshold: number };
  burning?: { omega?: number; propagation?: string; radius?: string };
  theta2?: number;
  theta1?: number;
  theta1_radii: number; ///< of the skeleton that was asked for; 0: none
  floor: { theta2: number; theta1: number };
  /// The faces of `core` are sorted by the first.
  measures: PruningMeasure[];
  topology?: { euler: number; betti: number[] };
  voxelSurface: boolean; ///< without sharp edges
  plane: boolean; ///< flat, seen from the front; curves without sheets
  yDown: boolean; ///< of a plane
  tree?: TreeMeta;
  columns: ColumnMeta[]; ///< of tables but those of the tree
  note: string;
  notes: string[];
  files: { core?: string; skeleton?: string; shape?: string };
  sites_to_world?: number[];
  /// What the page starts with, as in the address.
  state: string;
  arrays: ArrayEntry[];
}

/// Levels of the cells of a layer by one measure.
export interface Levels { face: Float32Array; edge: Float32Array; vertex: Float32Array }

/// A cell complex with levels; the arrays are views of the page's data.
export interface Layer {
  name: LayerKey;
  points: Float32Array;
  vertexCount: number;
  faceCount: number;
  edgeCount: number;
  offsets: Uint32Array;
  corners: Uint32Array;
  sides: Uint32Array;
  edges: Uint32Array;
  faceLevel: Float32Array | null;
  edgeLevel: Float32Array | null;
  vertexLevel: Float32Array | null;
  /// Those by the measures of the page but the first.
  otherLevels: Map<string, Levels>;
  curveEdges: Uint32Array | null;
  curveThickness: Float32Array | null;
  /// Vertices that are never pruned: the medial points.
  medialPoints: Uint32Array | null;
  measures: Map<string, Float32Array>;
  /// Per corner of a polygon, of `family`: fragments below theta2 are not drawn.
  cornerLevel: Float32Array | null;
  /// Per face and per edge (-1: none), of `skeleton`.
  sheet: Uint32Array | null;
  edgeBranch: Int32Array | null;
  branches: Branches | null;
  sheets: Sheets | null;
  collapses: Collapses | null; ///< of `simple`
  /// Of `tree`: per edge the number of the part it belongs to, by what there are parts of.
  parts: Map<string, Int32Array>;
  tree: Tree | null;
}

export const BRANCH_MEASURES = ["length", "mean_radius", "min_radius", "max_radius", "thickness", "tortuosity"] as const;
export type BranchMeasure = (typeof BRANCH_MEASURES)[number];
export const NODE_KINDS = ["end", "junction", "sheet", "loop", "isolated"];

/// The curves of a skeleton from node to node.
export interface Branches {
  count: number;
  offsets: Uint32Array;
  points: Uint32Array; ///< vertices along each
  measures: Record<BranchMeasure, Float32Array>;
  nodes: Uint32Array; ///< two of each
  nodePoints: Uint32Array;
  nodeKinds: Uint8Array;
}

/// The table of the sheets of the skeleton, a row for each number in `sheet`.
export interface Sheets { count: number; columns: Column[] }

export interface Shape {
  points: Float32Array | null;
  triangles: Uint32Array | null;
  sites: Uint16Array | null;
  samples: Float32Array | null;
  measures: Map<string, Float32Array>; ///< per point
}

export interface Page {
  meta: Meta;
  layers: Map<LayerKey, Layer>;
  shape: Shape;
}

const CHUNK = 1 << 20; // characters of base64 decoded at a time

/// The page's data, or null in the empty template.
export async function readPage(document: Document): Promise<Page | null> {
  const metaText = document.getElementById("quench-meta")?.textContent;
  const dataText = document.getElementById("quench-data")?.textContent;
  if (metaText == null && dataText == null) return null;
  if (metaText == null || dataText == null) throw new PageError("This page is incomplete: one of its two data elements is missing.");
  const meta = readMeta(metaText);
  const bytes = await inflate(dataText, sizeOf(meta.arrays));
  return assemble(meta, bytes);
}

export function readMeta(text: string): Meta {
  let raw: Partial<Meta>;
  try {
    raw = JSON.parse(text) as Partial<Meta>;
  } catch {
    throw new PageError("The description of the data in this page is damaged (no valid JSON); write the page anew.");
  }
  if (typeof raw !== "object" || raw === null) throw new PageError("The description of the data in this page is empty.");
  if (raw.format !== FORMAT)
    throw new PageError(`This page says data format ${raw.format}, its program reads ${FORMAT}; write it anew with one version of quench.`);
  if (!Array.isArray(raw.arrays)) throw new PageError("This page does not list its arrays; write it anew.");
  const triple = (v: unknown) => (Array.isArray(v) && v.length === 3 && v.every((x) => Number.isFinite(x)) ? (v as Meta["low"]) : undefined);
  const length = (v: unknown) => (typeof v === "number" && Number.isFinite(v) ? v : undefined);
  const low = triple(raw.low), high = triple(raw.high);
  const side = length(raw.side);
  if (!low || !high || !side || side <= 0) throw new PageError("This page does not say how large the shape is (side, low, high); write it anew.");
  // null stands for infinity, a missing value for unknown.
  const measures = Array.isArray(raw.measures) ? raw.measures.map((m) => ({ name: String(m?.name), floor: length(m?.floor) ?? 0 })) : [];
  const theta = (v: unknown) => (v === null ? Infinity : length(v));
  return {
    format: FORMAT,
    title: String(raw.title ?? "Quench"),
    program: String(raw.program ?? "quench"),
    command: String(raw.command ?? ""),
    unit: String(raw.unit ?? ""),
    side,
    voxel: length(raw.voxel),
    low,
    high,
    origin: triple(raw.origin) ?? [0, 0, 0],
    pruning: raw.pruning && { measure: String(raw.pruning.measure), threshold: theta(raw.pruning.threshold) ?? 0 },
    burning: raw.burning ?? undefined,
    theta2: theta(raw.theta2),
    theta1: theta(raw.theta1),
    theta1_radii: length(raw.theta1_radii) ?? 0,
    floor: { theta2: length(raw.floor?.theta2) ?? 0, theta1: length(raw.floor?.theta1) ?? 0 },
    measures,
    topology: raw.topology ?? undefined,
    voxelSurface: (raw as { surface?: unknown }).surface === "voxels",
    plane: (raw as { dimension?: unknown }).dimension === 2,
    yDown: (raw as { y_axis?: unknown }).y_axis === "down",
    tree: treeOf(raw.tree, triple),
    columns: columnsIn(raw.columns),
    note: typeof raw.note === "string" ? raw.note : "",
    notes: Array.isArray(raw.notes) ? raw.notes.map(String) : [],
    files: raw.files ?? {},
    sites_to_world: Array.isArray(raw.sites_to_world) && raw.sites_to_world.length === 12 ? raw.sites_to_world : undefined,
    state: typeof raw.state === "string" ? raw.state : "",
    arrays: raw.arrays,
  };
}

/// Directions and columns as they should be; undefined: there is no tree.
function treeOf(raw: Partial<TreeMeta> | undefined, triple: (v: unknown) => Triple | undefined): TreeMeta | undefined {
  if (typeof raw !== "object" || raw === null) return undefined;
  return { down: triple(raw.down) ?? [0, 0, -1], to_eye: triple(raw.to_eye) ?? [0, -1, 0], up: triple(raw.up) ?? [0, 0, 1], columns: columnsIn(raw.columns) };
}

function sizeOf(arrays: ArrayEntry[]): number {
  let size = 0;
  for (const a of arrays) {
    checkEntry(a);
    size = Math.max(size, Math.ceil((a.offset + bytesOf(a)) / 4) * 4); // arrays are filled up to four bytes
  }
  return size;
}

/// Base64 and gzip, a piece at a time, into one buffer of known size: no second copy of a large page.
async function inflate(text: string, size: number): Promise<Uint8Array> {
  if (typeof DecompressionStream === "undefined")
    throw new PageError("This browser is too old to unpack the page's data; use Chrome 80, Firefox 113, Safari 16.4 or later.");
  let bytes: Uint8Array;
  try {
    bytes = new Uint8Array(size);
  } catch {
    throw new PageError(`This browser has no room for the ${Math.round(size / 1e6)} MB of this page; write it anew with fewer faces.`);
  }
  let at = 0, carry = "";
  const base64 = new ReadableStream<Uint8Array<ArrayBuffer>>({
    pull(controller) {
      if (at >= text.length) {
        if (carry.length > 0) controller.error(new PageError("The data of this page end in the middle (base64); the file was cut off."));
        else controller.close();
        return;
      }
      const piece = carry + text.slice(at, at + CHUNK).replace(/\s+/g, "");
      at += CHUNK;
      const whole = piece.length - (piece.length % 4);
      carry = piece.slice(whole);
      let binary: string;
      try {
        binary = atob(piece.slice(0, whole));
      } catch {
        controller.error(new PageError("The data of this page are damaged (no valid base64)."));
        return;
      }
      const out = new Uint8Array(binary.length);
      for (let i = 0; i < binary.length; ++i) out[i] = binary.charCodeAt(i);
      controller.enqueue(out);
    },
  });
  const reader = base64.pipeThrough(new DecompressionStream("gzip")).getReader();
  let filled = 0;
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      if (filled + value.length > size) throw new PageError("The data of this page are longer than it says; write it anew.");
      bytes.set(value, filled);
      filled += value.length;
    }
  } catch (error) {
    if (error instanceof PageError) throw error;
    throw new PageError("The data of this page cannot be unpacked (damaged gzip); the file was cut off or changed.");
  }
  if (filled < size) throw new PageError(`The data of this page are incomplete: ${filled} of ${size} bytes.`);
  return bytes;
}

export type Numbers = Float32Array | Uint32Array | Uint16Array | Uint8Array;

export function assemble(meta: Meta, bytes: Uint8Array): Page {
  const arrays = unpack(meta.arrays, bytes);
  const others = meta.measures.slice(1).map((m) => m.name);
  for (const layer of ["family", "core", "still"]) complete(layer, layer === "core" ? others : [], arrays);
  const find = <T extends Numbers>(name: string, type: new (n: number) => T): T | null => {
    const found = arrays.get(name);
    if (found === undefined) return null;
    if (!(found instanceof type)) throw new PageError(`The array ${name} of this page has an unexpected type; write the page anew.`);
    return found as T;
  };
  const layers = new Map<LayerKey, Layer>();
  for (const name of LAYER_KEYS) {
    const layer = name === "tree" ? readTree(find, meta) : name === "skeleton" ? readSkeleton(find, meta) : name === "simple" ? readSimple(find) : readLayer(name, find, meta);
    if (layer) layers.set(name, layer);
  }
  const shape: Shape = {
    points: find("shape/points", Float32Array),
    triangles: find("shape/triangles", Uint32Array),
    sites: find("shape/sites", Uint16Array),
    samples: find("shape/samples", Float32Array),
    measures: new Map(),
  };
  for (const { name } of meta.arrays) {
    if (!name.startsWith("shape/point/")) continue;
    const values = find(name, Float32Array)!;
    if (values.length !== (shape.points?.length ?? 0) / 3) throw new PageError(`${name} of this page has ${values.length} values for ${(shape.points?.length ?? 0) / 3} points; the page is damaged.`);
    shape.measures.set(name.slice("shape/point/".length), values);
  }
  if (shape.triangles && shape.points) below(shape.triangles, shape.points.length / 3, "shape/triangles");
  if (layers.size === 0) throw new PageError("There is no medial axis in this page: every layer is empty.");
  return { meta, layers, shape };
}

export type Find = <T extends Numbers>(name: string, type: new (n: number) => T) => T | null;

function readLayer(name: LayerKey, find: Find, meta: Meta): Layer | null {
  const points = find(`${name}/points`, Float32Array);
  if (!points || points.length === 0) return null;
  const vertexCount = points.length / 3;
  if (!Number.isInteger(vertexCount)) throw new PageError(`${name}/points of this page has no three coordinates per point.`);
  if (points.some((x) => !Number.isFinite(x))) throw new PageError(`Coordinates of the layer ${name} are not numbers; the result this page shows is damaged.`);
  const offsets = find(`${name}/polygon_offsets`, Uint32Array) ?? new Uint32Array(1);
  const faceCount = Math.max(0, offsets.length - 1);
  const empty = new Uint32Array(0);
  const needed = <T extends Numbers>(array: string, type: new (n: number) => T, wanted: boolean): T | null => {
    const found = find(`${name}/${array}`, type);
    if (!found && wanted) throw new PageError(`The array ${name}/${array} is missing in this page; write it anew.`);
    return found;
  };
  const corners = needed("polygon_corners", Uint32Array, faceCount > 0) ?? empty;
  const sides = needed("polygon_edges", Uint32Array, faceCount > 0) ?? empty;
  const edges = needed("edges", Uint32Array, faceCount > 0) ?? empty;
  const edgeCount = edges.length / 2;
  for (let f = 0; f < faceCount; ++f)
    if (offsets[f + 1]! < offsets[f]!) throw new PageError(`${name}/polygon_offsets of this page does not increase; the page is damaged.`);
  if (corners.length < (offsets[faceCount] ?? 0) || sides.length < (offsets[faceCount] ?? 0))
    throw new PageError(`${name}/polygon_corners or polygon_edges of this page is too short; the page is damaged.`);
  below(corners, vertexCount, `${name}/polygon_corners`);
  below(sides, edgeCount, `${name}/polygon_edges`);
  below(edges, vertexCount, `${name}/edges`);
  if (name === "core" && meta.measures.length === 0) throw new PageError("This page does not say by which measure its medial axis is pruned; write it anew.");
  const levels = name !== "still";
  const sized = (array: string, count: number, wanted: boolean) => {
    const found = needed(array, Float32Array, wanted);
    if (found && found.length !== count) throw new PageError(`${name}/${array} of this page has ${found.length} values for ${count} cells; the page is damaged.`);
    return found;
  };
  const measures = new Map<string, Float32Array>();
  const prefix = `${name}/point/`;
  for (const a of meta.arrays)
    if (a.name.startsWith(prefix)) measures.set(a.name.slice(prefix.length), sized(`point/${a.name.slice(prefix.length)}`, vertexCount, true)!);
  const faceLevel = sized("face_level", faceCount, levels && faceCount > 0);
  if (faceLevel)
    for (let f = 1; f < faceCount; ++f)
      if (!(faceLevel[f]! <= faceLevel[f - 1]!)) throw new PageError(`The faces of the layer ${name} are not sorted by level; the page is damaged.`);
  const otherLevels = new Map<string, Levels>();
  if (name === "core")
    for (const { name: m } of meta.measures.slice(1))
      otherLevels.set(m, { face: sized(`face_level/${m}`, faceCount, true)!, edge: sized(`edge_level/${m}`, edgeCount, true)!, vertex: sized(`vertex_level/${m}`, vertexCount, true)! });
  const curveEdges = needed("curve_edges", Uint32Array, false);
  const curveThickness = curveEdges ? sized("curve_thickness", curveEdges.length, true) : null;
  if (curveEdges) below(curveEdges, edgeCount, `${name}/curve_edges`);
  const medialPoints = needed("medial_points", Uint32Array, false);
  if (medialPoints) below(medialPoints, vertexCount, `${name}/medial_points`);
  return {
    name, points, vertexCount, faceCount, edgeCount, offsets, corners, sides, edges, faceLevel,
    edgeLevel: sized("edge_level", edgeCount, levels && edgeCount > 0),
    vertexLevel: sized("vertex_level", vertexCount, levels),
    otherLevels, curveEdges, curveThickness, medialPoints, measures,
    cornerLevel: sized("corner_level", corners.length, false), sheet: null, edgeBranch: null, branches: null, sheets: null, collapses: null, parts: new Map(), tree: null,
  };
}

/// The skeleton that was asked for: the sides of its polygons are found here, the segments of its branches are edges.
function readSkeleton(find: Find, meta: Meta): Layer | null {
  const points = find("skeleton/points", Float32Array);
  if (!points || points.length === 0) return null;
  const vertexCount = points.length / 3;
  if (!Number.isInteger(vertexCount) || points.some((x) => !Number.isFinite(x))) throw new PageError("Coordinates of the skeleton are not numbers; the result this page shows is damaged.");
  const needed = <T extends Numbers>(array: string, type: new (n: number) => T): T => {
    const found = find(`skeleton/${array}`, type);
    if (!found) throw new PageError(`The array skeleton/${array} is missing in this page; write it anew.`);
    return found;
  };
  const ranges = (array: string, end: number) => {
    const offsets = needed(array, Uint32Array);
    for (let i = 0; i + 1 < offsets.length; ++i) if (offsets[i + 1]! < offsets[i]!) throw new PageError(`skeleton/${array} of this page does not increase; the page is damaged.`);
    if (offsets.length === 0 || offsets[offsets.length - 1] !== end) throw new PageError(`skeleton/${array} of this page does not end where it should; the page is damaged.`);
    return offsets;
  };
  const corners = needed("polygon_corners", Uint32Array), offsets = ranges("polygon_offsets", corners.length), faceCount = offsets.length - 1;
  const along = needed("branch_points", Uint32Array), branchOffsets = ranges("branch_offsets", along.length), branchCount = branchOffsets.length - 1;
  const nodes = needed("branch_nodes", Uint32Array), nodePoints = needed("node_points", Uint32Array), nodeKinds = needed("node_kind", Uint8Array);
  below(corners, vertexCount, "skeleton/polygon_corners");
  below(along, vertexCount, "skeleton/branch_points");
  below(nodes, nodePoints.length, "skeleton/branch_nodes");
  below(nodePoints, vertexCount, "skeleton/node_points");
  const sized = (array: string, count: number) => {
    const found = needed(array, Float32Array);
    if (found.length !== count) throw new PageError(`skeleton/${array} of this page has ${found.length} values for ${count}; the page is damaged.`);
    return found;
  };
  const { sides, edges } = sidesOf(offsets, corners);
  const branchEdges: number[] = [];
  for (let b = 0; b < branchCount; ++b)
    for (let i = branchOffsets[b]! + 1; i < branchOffsets[b + 1]!; ++i) branchEdges.push(along[i - 1]!, along[i]!, b);
  const first = edges.length / 2, lone = branchEdges.length / 3, all = new Uint32Array(2 * (first + lone));
  all.set(edges);
  const edgeBranch = new Int32Array(first + lone).fill(-1);
  for (let i = 0; i < lone; ++i) {
    all[2 * (first + i)] = branchEdges[3 * i]!;
    all[2 * (first + i) + 1] = branchEdges[3 * i + 1]!;
    edgeBranch[first + i] = branchEdges[3 * i + 2]!;
  }
  const measures = new Map<string, Float32Array>(), prefix = "skeleton/point/";
  for (const a of meta.arrays) if (a.name.startsWith(prefix)) measures.set(a.name.slice(prefix.length), sized(`point/${a.name.slice(prefix.length)}`, vertexCount));
  const sheet = needed("polygon_sheet", Uint32Array);
  if (sheet.length !== faceCount) throw new PageError("skeleton/polygon_sheet of this page does not fit its polygons; the page is damaged.");
  const ofBranches = Object.fromEntries(BRANCH_MEASURES.map((name) => [name, sized(`branch/${name}`, branchCount)])) as Record<BranchMeasure, Float32Array>;
  return {
    name: "skeleton", points, vertexCount, faceCount, edgeCount: first + lone, offsets, corners, sides, edges: all, faceLevel: null, edgeLevel: null, vertexLevel: null,
    otherLevels: new Map(), curveEdges: null, curveThickness: null, medialPoints: null, measures, cornerLevel: null, sheet, edgeBranch, sheets: sheetsOf(find, meta, sheet), collapses: null,
    branches: branchCount > 0 ? { count: branchCount, offsets: branchOffsets, points: along, measures: ofBranches, nodes, nodePoints, nodeKinds } : null, parts: new Map(), tree: null,
  };
}

/// The table of sheets, where the page has one.
function sheetsOf(find: Find, meta: Meta, sheet: Uint32Array): Sheets | null {
  const known = meta.columns.filter((c) => c.table === "sheets");
  if (known.length === 0) return null;
  const columns = known.map((c) => {
    const values = find(`sheets/${c.name}`, Float32Array);
    if (!values) throw new PageError(`The array sheets/${c.name} is missing in this page; write it anew.`);
    return columnOf(c, values);
  });
  const count = columns[0]!.values.length;
  if (columns.some((c) => c.values.length !== count) || sheet.some((s) => s >= count)) throw new PageError("The table of sheets of this page does not fit its skeleton; the page is damaged.");
  return { count, columns };
}

/// The layer of medial meshes, with the finest of them.
function readSimple(find: Find): Layer | null {
  const points = find("simple/points", Float32Array);
  if (!points || points.length === 0) return null;
  const needed = <T extends Numbers>(array: string, type: new (n: number) => T): T => {
    const found = find(`simple/${array}`, type);
    if (!found) throw new PageError(`The array simple/${array} is missing in this page; write it anew.`);
    return found;
  };
  const collapses = new Collapses({
    points, radius: needed("point/radius", Float32Array), triangles: needed("triangles", Uint32Array), edges: needed("edges", Uint32Array),
    steps: needed("steps", Uint32Array), stepPoints: needed("step_points", Float32Array), stepRadius: needed("step_radius", Float32Array), errors: find("simple/errors", Float32Array),
  });
  return collapses.at(collapses.most);
}

/// The layer with the levels by another measure, and its faces in decreasing order of them.
export function byMeasure(layer: Layer, measure: string): Layer {
  const levels = layer.otherLevels.get(measure);
  if (!levels) return layer;
  const order = Uint32Array.from({ length: layer.faceCount }, (_, f) => f).sort((a, b) => levels.face[b]! - levels.face[a]! || a - b);
  const offsets = new Uint32Array(layer.faceCount + 1), corners = new Uint32Array(layer.corners.length), sides = new Uint32Array(layer.sides.length);
  order.forEach((f, row) => {
    const begin = layer.offsets[f]!, end = layer.offsets[f + 1]!;
    corners.set(layer.corners.subarray(begin, end), offsets[row]!);
    sides.set(layer.sides.subarray(begin, end), offsets[row]!);
    offsets[row + 1] = offsets[row]! + end - begin;
  });
  return { ...layer, offsets, corners, sides, faceLevel: Float32Array.from(order, (f) => levels.face[f]!), edgeLevel: levels.edge, vertexLevel: levels.vertex };
}

function below(indices: Uint32Array, limit: number, name: string): void {
  for (let i = 0; i < indices.length; ++i)
    if (indices[i]! >= limit) throw new PageError(`${name} of this page points beyond its end; the page is damaged.`);
}
