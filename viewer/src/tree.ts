// SPDX-License-Identifier: Apache-2.0
// The layer `tree` (FORMAT.md, "Trees"): branches as courses with radii, the tables of axes, branches and the sample,
// and the places where it was repaired.
import type { EditGroup } from "./colours";
import type { ArrayEntry, Find, Layer, Meta, Triple } from "./data";
import { PageError } from "./page_error";
import { columnOf, type Column, type ColumnMeta } from "./table";

export const TABLES = ["axes", "branches", "sample", "edits"] as const;
export type TableName = (typeof TABLES)[number];
const isTable = (name: string): name is TableName => (TABLES as readonly string[]).includes(name);
export const ROWS = ["axes", "branches", "edits"] as const; ///< tables that are shown as such
export type Rows = (typeof ROWS)[number];

/// What the page says of its tree beside the arrays.
export interface TreeMeta {
  down: Triple;
  to_eye: Triple; ///< from where it is seen first
  up: Triple;
  columns: ColumnMeta[];
}

export const groupOf = (kind: string): EditGroup => (kind === "bridge" ? "bridges" : kind === "left_out" ? "leftOut" : "cuts");

const NONE = 0xffffffff;
const MANY_MARKS = 200; ///< would hide the tree: not shown at first

export class Tree {
  readonly axisCount: number;
  readonly branchCount: number;
  readonly editCount: number;
  readonly axisBranches: number[][] = []; ///< from base to tip
  readonly axisLength: Float64Array;
  readonly levels: { axes: number; length: number }[] = [];
  readonly depth: number; ///< how far it reaches along `down`

  constructor(
    readonly meta: TreeMeta,
    points: Float32Array,
    readonly offsets: Uint32Array, ///< per branch where its points begin
    readonly branchParent: Uint32Array,
    readonly branchAxis: Uint32Array,
    readonly axisParent: Uint32Array,
    readonly axisLevel: Uint32Array,
    readonly editPoints: Float32Array, ///< of each its two ends
    readonly tables: Record<TableName, Column[]>,
  ) {
    this.axisCount = axisLevel.length;
    this.branchCount = branchAxis.length;
    this.editCount = editPoints.length / 6;
    this.axisLength = new Float64Array(this.axisCount);
    for (let a = 0; a < this.axisCount; ++a) this.axisBranches.push([]);
    branchAxis.forEach((a, b) => {
      this.axisBranches[a]!.push(b);
      for (let i = 3 * offsets[b]!; i + 3 < 3 * offsets[b + 1]!; i += 3) this.axisLength[a]! += Math.hypot(points[i + 3]! - points[i]!, points[i + 4]! - points[i + 1]!, points[i + 5]! - points[i + 2]!);
    });
    // Where a course begins later than its branches, that of the table counts.
    const measured = this.column("axes", "length");
    for (let a = 0; a < this.axisCount; ++a) {
      if (measured) this.axisLength[a] = measured.values[a]!;
      const level = axisLevel[a]!;
      while (this.levels.length <= level) this.levels.push({ axes: 0, length: 0 });
      ++this.levels[level]!.axes;
      this.levels[level]!.length += this.axisLength[a]!;
    }
    let low = Infinity, high = -Infinity;
    for (let i = 0; i < points.length; i += 3) {
      const at = points[i]! * meta.down[0] + points[i + 1]! * meta.down[1] + points[i + 2]! * meta.down[2];
      low = Math.min(low, at);
      high = Math.max(high, at);
    }
    this.depth = high - low;
  }

  column(table: TableName, name: string): Column | undefined { return this.tables[table].find((c) => c.name === name); }
  /// A number of the table of the sample; NaN: it has none.
  sample(name: string): number { return this.column("sample", name)?.values[0] ?? NaN; }

  /// What parts are called by which it is coloured; where their numbers are their names, nothing.
  partNames(color: string): string[] {
    if (color === "bridged") return ["in the shape", "bridged"];
    return color === "level" ? this.levels.slice(0, 12).map((_, level) => `level ${level}`) : [];
  }

  count(rows: Rows): number { return rows === "axes" ? this.axisCount : rows === "branches" ? this.branchCount : this.editCount; }
  kind(edit: number): string { const kinds = this.column("edits", "kind"); return kinds?.words?.[kinds.values[edit]!] ?? ""; }

  /// Whether marks are shown at first.
  marksAtFirst(group: EditGroup): boolean {
    let count = 0;
    for (let i = 0; i < this.editCount; ++i) count += Number(groupOf(this.kind(i)) === group);
    return group !== "leftOut" && count <= MANY_MARKS;
  }

  branchesOf(rows: Rows, row: number): number[] { return row < 0 || rows === "edits" ? [] : rows === "axes" ? this.axisBranches[row]! : [row]; }
  /// The branches from where it begins to the root node.
  pathOf(rows: Rows, row: number): number[] {
    const first = this.branchesOf(rows, row)[0], path: number[] = [];
    if (first === undefined) return path;
    for (let b = this.branchParent[first]!; b !== NONE; b = this.branchParent[b]!) path.push(b);
    return path;
  }
  /// The numbers of their edges: each branch has one less than it has points.
  edgesOf(branches: number[]): Uint32Array {
    const list: number[] = [];
    for (const b of branches) for (let e = this.offsets[b]! - b; e < this.offsets[b + 1]! - b - 1; ++e) list.push(e);
    return Uint32Array.from(list);
  }
}

/// Columns that number things: nothing to colour by.
const NUMBERS = ["axis", "branch", "parent", "plant", "id"];

/// The layer of the tree, whose edges are the segments of its branches in their order.
export function readTree(find: Find, meta: Meta): Layer | null {
  const points = find("tree/points", Float32Array);
  if (!points || points.length === 0) return null;
  const damaged = (what: string): never => { throw new PageError(`${what} of this page does not fit its tree; the page is damaged.`); };
  const needed = <T extends Float32Array | Uint32Array>(array: string, type: new (n: number) => T, size?: number): T => {
    const found = find(`tree/${array}`, type);
    if (!found) throw new PageError(`The array tree/${array} is missing in this page; write it anew.`);
    if (size !== undefined && found.length !== size) damaged(`tree/${array}`);
    return found;
  };
  const raw = meta.tree;
  if (!raw) throw new PageError("This page does not describe its tree; write it anew.");
  const vertexCount = points.length / 3;
  if (!Number.isInteger(vertexCount) || points.some((x) => !Number.isFinite(x))) throw new PageError("Coordinates of the tree are not numbers; the result this page shows is damaged.");
  const offsets = needed("branch_offsets", Uint32Array), branchCount = offsets.length - 1;
  for (let b = 0; b < branchCount; ++b) if (offsets[b + 1]! < offsets[b]! + 2) damaged("tree/branch_offsets");
  if (branchCount < 1 || offsets[0] !== 0 || offsets[branchCount] !== vertexCount) damaged("tree/branch_offsets");
  const axisLevel = needed("axis_level", Uint32Array), axisCount = axisLevel.length;
  const axisParent = needed("axis_parent", Uint32Array, axisCount), axisPlant = needed("axis_plant", Uint32Array, axisCount);
  const branchAxis = needed("branch_axis", Uint32Array, branchCount), branchParent = needed("branch_parent", Uint32Array, branchCount);
  if (axisLevel.some((level) => level > axisCount) || branchAxis.some((a) => a >= axisCount)) damaged("tree/branch_axis");
  // Parents come first, so every way to the root node ends.
  if (branchParent.some((p, b) => p !== NONE && p >= b)) damaged("tree/branch_parent");
  if (axisParent.some((p, a) => p !== NONE && p >= a)) damaged("tree/axis_parent");
  const bridged = needed("bridged", Uint32Array), editPoints = needed("edit_points", Float32Array);
  if (editPoints.length % 6 !== 0) damaged("tree/edit_points");
  const sizes: Record<TableName, number> = { axes: axisCount, branches: branchCount, sample: 1, edits: editPoints.length / 6 };
  const tables: Record<TableName, Column[]> = { axes: [], branches: [], sample: [], edits: [] };
  for (const c of raw.columns)
    if (isTable(c.table)) tables[c.table].push(columnOf(c, needed(`${c.table}/${c.name}`, Float32Array, sizes[c.table])));

  const edgeCount = vertexCount - branchCount, edges = new Uint32Array(2 * edgeCount), edgeBranch = new Int32Array(edgeCount), isBridged = new Uint8Array(vertexCount);
  for (const v of bridged) isBridged[v] = 1;
  const bridgedPart = new Int32Array(edgeCount);
  for (let b = 0, e = 0; b < branchCount; ++b)
    for (let v = offsets[b]!; v + 1 < offsets[b + 1]!; ++v, ++e) {
      edges.set([v, v + 1], 2 * e);
      edgeBranch[e] = b;
      bridgedPart[e] = isBridged[v]!;
    }
  const ofEdges = (value: (branch: number) => number) => Int32Array.from(edgeBranch, value);
  const parts = new Map([["level", ofEdges((b) => axisLevel[branchAxis[b]!]!)], ["axis", ofEdges((b) => branchAxis[b]!)], ["branch", ofEdges((b) => b)]]);
  if (axisPlant.some((p) => p !== axisPlant[0])) parts.set("plant", ofEdges((b) => axisPlant[branchAxis[b]!]!));
  if (bridged.length > 0) parts.set("bridged", bridgedPart);
  const measures = new Map<string, Float32Array>(), ofPoints = (value: (branch: number) => number) => {
    const values = new Float32Array(vertexCount);
    for (let b = 0; b < branchCount; ++b) values.fill(value(b), offsets[b], offsets[b + 1]);
    return values;
  };
  for (const name of ["strahler", "order"]) {
    const numbers = needed(`branch_${name}`, Uint32Array, branchCount);
    measures.set(name, ofPoints((b) => numbers[b]!));
  }
  for (const { name } of meta.arrays.filter((a: ArrayEntry) => a.name.startsWith("tree/point/"))) measures.set(name.slice("tree/point/".length), needed(name.slice("tree/".length), Float32Array, vertexCount));
  const measured = (c: Column) => !c.words && !(c.whole && NUMBERS.includes(c.name));
  for (const c of tables.axes) if (measured(c)) measures.set(`axes/${c.name}`, ofPoints((b) => c.values[branchAxis[b]!]!));
  for (const c of tables.branches) if (measured(c)) measures.set(`branches/${c.name}`, ofPoints((b) => c.values[b]!));
  const none = new Uint32Array(0);
  return {
    name: "tree", points, vertexCount, faceCount: 0, edgeCount, offsets: new Uint32Array(1), corners: none, sides: none, edges, faceLevel: null, edgeLevel: null, vertexLevel: null,
    otherLevels: new Map(), curveEdges: null, curveThickness: null, medialPoints: null, measures, cornerLevel: null, sheet: null, edgeBranch, branches: null, sheets: null, collapses: null, parts,
    tree: new Tree(raw, points, offsets, branchParent, branchAxis, axisParent, axisLevel, editPoints, tables),
  };
}
