// SPDX-License-Identifier: Apache-2.0
// Medial meshes of any number of vertices (FORMAT.md, "Medial meshes"): the finest one, and steps that make each from the
// one before.
import type { Layer } from "./data";
import { PageError } from "./page_error";
import { sidesOf } from "./unpack";

/// What a page has of medial meshes.
export interface MeshData {
  points: Float32Array; ///< of the finest
  radius: Float32Array;
  triangles: Uint32Array;
  edges: Uint32Array; ///< that are no sides of triangles
  steps: Uint32Array; ///< per step the vertex that stays and the one that becomes one with it; the same: it moves only
  stepPoints: Float32Array; ///< of the vertex that stays, from then on
  stepRadius: Float32Array;
  errors: Float32Array | null; ///< rows of a number of vertices and the mean, the 99th percentile and the largest distance
}

/// Distances of the boundary to the envelope of a mesh.
export interface MeshError { mean: number; most99: number; largest: number; exact: boolean }

export class Collapses {
  readonly most: number; ///< vertices of the finest
  readonly least: number;
  readonly radii: Float32Array; ///< all there are, for the range of colours
  readonly errorRows: { vertices: number; values: [number, number, number] }[] = [];
  private last: { count: number; layer: Layer } | null = null;

  constructor(private readonly data: MeshData) {
    const { points, radius, triangles, edges, steps, stepPoints, stepRadius, errors } = data;
    const damaged = (): never => { throw new PageError("The medial meshes of this page do not fit together; the page is damaged."); };
    const count = steps.length / 2;
    this.most = points.length / 3;
    if (!Number.isInteger(this.most) || radius.length !== this.most || edges.length % 2 !== 0 || triangles.length % 3 !== 0) damaged();
    if (!Number.isInteger(count) || stepPoints.length !== 3 * count || stepRadius.length !== count || (errors && errors.length % 4 !== 0)) damaged();
    if (points.some((x) => !Number.isFinite(x)) || stepPoints.some((x) => !Number.isFinite(x)) || edges.some((v) => v >= this.most) || triangles.some((v) => v >= this.most)) damaged();
    const gone = new Uint8Array(this.most);
    let left = this.most;
    for (let i = 0; i < count; ++i) {
      const kept = steps[2 * i]!, removed = steps[2 * i + 1]!;
      if (kept >= this.most || removed >= this.most || gone[kept] || gone[removed]) damaged();
      if (kept === removed) continue;
      gone[removed] = 1;
      --left;
    }
    this.least = left;
    this.radii = new Float32Array(this.most + count);
    this.radii.set(radius);
    this.radii.set(stepRadius, this.most);
    for (let i = 0; errors && i < errors.length; i += 4) this.errorRows.push({ vertices: errors[i]!, values: [errors[i + 1]!, errors[i + 2]!, errors[i + 3]!] });
    this.errorRows.sort((a, b) => a.vertices - b.vertices);
  }

  clamp(count: number): number { return Number.isNaN(count) ? this.most : Math.min(this.most, Math.max(this.least, Math.round(count))); }

  /// Of the mesh of so many vertices; between two of which it is known along a line in logarithms. null: not known.
  error(count: number): MeshError | null {
    const rows = this.errorRows, at = rows.findIndex((row) => row.vertices >= count), above = rows[at], below = rows[at - 1];
    if (above?.vertices === count) return { mean: above.values[0], most99: above.values[1], largest: above.values[2], exact: true };
    if (!above || !below) return null;
    const t = Math.log(count / below.vertices) / Math.log(above.vertices / below.vertices), of = (k: 0 | 1 | 2) => below.values[k] ** (1 - t) * above.values[k] ** t;
    return { mean: of(0), most99: of(1), largest: of(2), exact: false };
  }

  /// The mesh of so many vertices: after all steps before the one that would take away one more. Vertices are those left
  /// of the finest, in their order.
  at(count: number): Layer {
    if (this.last?.count === count) return this.last.layer;
    const layer = this.make(count);
    this.last = { count, layer };
    return layer;
  }

  private make(wanted: number): Layer {
    const { most, data: { steps, stepPoints, stepRadius } } = this, points = this.data.points.slice(), radius = this.data.radius.slice(), into = Uint32Array.from({ length: most }, (_, v) => v);
    let left = most, begun = 0;
    for (; 2 * begun < steps.length; ++begun) {
      const kept = steps[2 * begun]!, removed = steps[2 * begun + 1]!;
      if (kept !== removed) {
        if (left === wanted) break;
        into[removed] = kept;
        --left;
      }
      points.set(stepPoints.subarray(3 * begun, 3 * begun + 3), 3 * kept);
      radius[kept] = stepRadius[begun]!;
    }
    const rootOf = (v: number) => {
      while (into[v] !== v) v = into[v] = into[into[v]!]!;
      return v;
    };
    const row = new Int32Array(most).fill(-1);
    let vertexCount = 0;
    for (let v = 0; v < most; ++v) {
      if (into[v] !== v) continue;
      row[v] = vertexCount;
      points.copyWithin(3 * vertexCount, 3 * v, 3 * v + 3);
      radius[vertexCount++] = radius[v]!;
    }
    for (let v = 0; v < most; ++v) row[v] = row[rootOf(v)]!;
    const { faces, edges } = this.cells(row, vertexCount), faceCount = faces.length / 3, offsets = Uint32Array.from({ length: faceCount + 1 }, (_, f) => 3 * f);
    const found = sidesOf(offsets, faces), ends = new Uint32Array(found.edges.length + edges.length);
    ends.set(found.edges);
    ends.set(edges, found.edges.length);
    return {
      name: "simple", points: points.slice(0, 3 * vertexCount), vertexCount, faceCount, edgeCount: ends.length / 2, offsets, corners: faces, sides: found.sides, edges: ends, faceLevel: null, edgeLevel: null, vertexLevel: null,
      otherLevels: new Map(), curveEdges: null, curveThickness: null, medialPoints: null, measures: new Map([["radius", radius.slice(0, vertexCount)]]), cornerLevel: null, sheet: null, edgeBranch: null, branches: null, sheets: null,
      collapses: this, parts: new Map(), tree: null,
    };
  }

  /// Triangles with three different corners, each once, and the edges that are not their sides; `row`: of each vertex of
  /// the finest mesh its number now.
  private cells(row: Int32Array, count: number): { faces: Uint32Array; edges: Uint32Array } {
    const { triangles, edges } = this.data, faces: number[] = [], lone: number[] = [], seen = new Set<number>(), sides = new Set<number>();
    const pair = (a: number, b: number) => Math.min(a, b) * count + Math.max(a, b);
    const flat: number[] = []; // sides of triangles that are none any more
    for (let t = 0; t < triangles.length; t += 3) {
      const a = row[triangles[t]!]!, b = row[triangles[t + 1]!]!, c = row[triangles[t + 2]!]!;
      if (a === b || b === c || a === c) {
        if (a !== b || b !== c) flat.push(a, a === b ? c : b);
        continue;
      }
      const low = Math.min(a, b, c), high = Math.max(a, b, c), key = (low * count + (a + b + c - low - high)) * count + high;
      if (seen.has(key)) continue;
      seen.add(key);
      faces.push(a, b, c);
      for (const [u, v] of [[a, b], [b, c], [c, a]] as const) sides.add(pair(u, v));
    }
    const offer = (a: number, b: number) => {
      if (a === b || sides.has(pair(a, b))) return;
      sides.add(pair(a, b));
      lone.push(a, b);
    };
    for (let e = 0; e < edges.length; e += 2) offer(row[edges[e]!]!, row[edges[e + 1]!]!);
    for (let e = 0; e < flat.length; e += 2) offer(flat[e]!, flat[e + 1]!);
    return { faces: Uint32Array.from(faces), edges: Uint32Array.from(lone) };
  }
}
