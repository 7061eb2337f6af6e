// SPDX-License-Identifier: Apache-2.0
// Which cells of a layer are there for given parameters (FORMAT.md, "The sets"). Everything that does not depend on the
// parameters is found once; after that a set takes one pass over the edges that can be curve, boundary or seam.
import type { Layer } from "./data";

/// What is visible, in buffers that are reused from call to call.
export interface CellSet {
  faces: number; ///< the first so many faces
  triangles: number; ///< after fanning them
  edges: number;
  vertices: number;
  area: number;
  freeEnds: number; ///< edges of length zero are none
  /// Edges with no, one, and three or more visible faces; the buffers hold `count` of them.
  curves: EdgeList;
  boundary: EdgeList;
  seams: EdgeList;
  isolated: VertexList;
  /// 1 where a vertex was pruned with its curve; the others are there when their level says so.
  pruned: Uint8Array;
  level: number;
}
export interface EdgeList { edge: Uint32Array; count: number; length: number }
export interface VertexList { vertex: Uint32Array; count: number }

const NEVER = -Infinity;

export class LayerSets {
  readonly layer: Layer;
  /// Per edge the largest, second and third level of the faces around it: they say how many are there.
  private readonly first: Float32Array;
  private readonly second: Float32Array;
  private readonly third: Float32Array;
  private readonly edgeLevel: Float32Array;
  private readonly vertexLevel: Float32Array;
  private readonly sortedVertexLevel: Float32Array;
  private readonly sortedEdgeLevel: Float32Array;
  private readonly areaBefore: Float64Array;
  private readonly leastCorner: Float32Array | null; ///< per face: parts of it are missing at larger levels
  private readonly lengths: Float32Array;
  private readonly thickness: Float32Array; ///< per edge: infinite where it is no curve
  private readonly loneEdges: Uint32Array; ///< edges that have no face for some parameter
  private readonly rimEdges: Uint32Array; ///< ... exactly one
  private readonly seamEdges: Uint32Array; ///< ... three or more
  private readonly loneVertices: Uint32Array; ///< vertices of lone edges, and those without any edge
  // The passes over lone edges read what they need in order, by numbers of lone edges and lone vertices.
  private readonly ends: Uint32Array; ///< two lone vertices per lone edge
  private readonly endsNow: Uint32Array; ///< ... of a piece off the sheets one, and a vertex that is none
  private readonly loneLevel: Float32Array;
  private readonly loneFirst: Float32Array;
  /// Of curves in layers with levels of corners: the levels of their faces at their two ends, from `levelsAt` on.
  private readonly levelsAt: Uint32Array;
  private readonly levels: Float32Array;
  private readonly bare: Float32Array; ///< per lone edge: the share of it that is off the sheets
  private readonly shownLevel: Float32Array; ///< per vertex: that of what is drawn there
  private readonly loneThickness: Float32Array;
  private readonly loneLength: Float32Array;
  private readonly held: Float32Array; ///< per lone vertex: the largest level of edges that are no lone edges
  private readonly ownLevel: Float32Array; ///< ... its own
  private readonly keep: Uint8Array; ///< ... never pruned
  private readonly degree: Uint32Array; ///< ... lone edges there
  private readonly edgeXor: Uint32Array;
  private readonly out: Uint8Array; ///< ... pruned, or drawn together with a neighbour
  private readonly gone: Uint8Array; ///< per lone edge: pruned
  private readonly stack: Uint32Array;
  private readonly set: CellSet;
  readonly triangleOffset: Uint32Array;

  constructor(layer: Layer) {
    this.layer = layer;
    const { faceCount, edgeCount, vertexCount, offsets, corners, sides, edges, points } = layer;
    const always = (n: number) => new Float32Array(n).fill(Infinity);
    const faceLevel = layer.faceLevel ?? always(faceCount);
    this.edgeLevel = Float32Array.from(layer.edgeLevel ?? always(edgeCount));
    this.vertexLevel = Float32Array.from(layer.vertexLevel ?? always(vertexCount));
    this.thickness = always(edgeCount);
    if (layer.curveEdges && layer.curveThickness)
      for (let i = 0; i < layer.curveEdges.length; ++i) {
        const e = layer.curveEdges[i]!;
        this.thickness[e] = layer.curveThickness[i]!;
        this.edgeLevel[e] = Infinity;
        this.vertexLevel[edges[2 * e]!] = this.vertexLevel[edges[2 * e + 1]!] = Infinity;
      }
    this.first = new Float32Array(edgeCount).fill(NEVER);
    this.second = new Float32Array(edgeCount).fill(NEVER);
    this.third = new Float32Array(edgeCount).fill(NEVER);
    const { cornerLevel } = layer;
    this.leastCorner = cornerLevel && Float32Array.from({ length: faceCount }, (_, f) => cornerLevel.subarray(offsets[f]!, offsets[f + 1]!).reduce((least, x) => Math.min(least, x), Infinity));
    this.areaBefore = new Float64Array(faceCount + 1);
    this.triangleOffset = new Uint32Array(faceCount + 1);
    for (let f = 0; f < faceCount; ++f) {
      const begin = offsets[f]!, end = offsets[f + 1]!, level = faceLevel[f]!;
      // Faces come in decreasing order, so the first three are the largest.
      for (let i = begin; i < end; ++i) {
        const e = sides[i]!;
        if (this.first[e] === NEVER) this.first[e] = level;
        else if (this.second[e] === NEVER) this.second[e] = level;
        else if (this.third[e] === NEVER) this.third[e] = level;
      }
      this.areaBefore[f + 1] = this.areaBefore[f]! + this.polygonArea(begin, end);
      this.triangleOffset[f + 1] = this.triangleOffset[f]! + Math.max(0, end - begin - 2);
    }
    this.lengths = new Float32Array(edgeCount);
    const held = new Float32Array(vertexCount).fill(NEVER);
    const isCurve = new Uint8Array(edgeCount);
    if (cornerLevel) for (const e of layer.curveEdges ?? []) isCurve[e] = 1;
    let lone = 0, rim = 0, seam = 0;
    const isLone = (e: number) => isCurve[e] === 1 || this.edgeLevel[e]! > this.first[e]!;
    const isRim = (e: number) => this.first[e]! > this.second[e]!;
    const isSeam = (e: number) => this.third[e]! > NEVER;
    for (let e = 0; e < edgeCount; ++e) {
      const a = 3 * edges[2 * e]!, b = 3 * edges[2 * e + 1]!;
      this.lengths[e] = Math.hypot(points[a]! - points[b]!, points[a + 1]! - points[b + 1]!, points[a + 2]! - points[b + 2]!);
      if (isLone(e)) ++lone;
      if (isRim(e)) ++rim;
      if (isSeam(e)) ++seam;
    }
    const pick = (count: number, wanted: (e: number) => boolean) => {
      const list = new Uint32Array(count);
      for (let e = 0, n = 0; e < edgeCount; ++e) if (wanted(e)) list[n++] = e;
      return list;
    };
    this.loneEdges = pick(lone, isLone);
    this.rimEdges = pick(rim, isRim);
    this.seamEdges = pick(seam, isSeam);
    const role = new Uint8Array(vertexCount); // 1: has an edge that is never lone, 2: has a lone one
    for (let e = 0; e < edgeCount; ++e)
      for (let i = 0; i < 2; ++i) {
        const v = edges[2 * e + i]!;
        if (isLone(e)) role[v]! |= 2;
        else {
          role[v]! |= 1;
          held[v] = Math.max(held[v]!, this.edgeLevel[e]!);
        }
      }
    // Vertices that may be left alone: of lone edges, and those that outlast their edges.
    const isAlone = Uint8Array.from(role, (r, v) => Number((r & 2) !== 0 || this.vertexLevel[v]! > held[v]!));
    const own = this.vertexLevel.slice();
    if (cornerLevel) {
      const most = held.slice(), ofLone = new Float32Array(vertexCount).fill(NEVER);
      for (let e = 0; e < edgeCount; ++e)
        if (isLone(e))
          for (const v of [edges[2 * e]!, edges[2 * e + 1]!]) {
            most[v] = Math.max(most[v]!, this.edgeLevel[e]!);
            ofLone[v] = Math.max(ofLone[v]!, this.edgeLevel[e]!);
          }
      for (let v = 0; v < vertexCount; ++v) if (!(own[v]! > most[v]!)) own[v] = ofLone[v]!;
      held.fill(NEVER);
      corners.forEach((v, i) => { held[v] = Math.max(held[v]!, cornerLevel[i]!); });
    }
    this.shownLevel = cornerLevel ? this.vertexLevel.map((level, v) => (isAlone[v] ? level : held[v]!)) : this.vertexLevel;
    const loneVertices: number[] = [];
    for (let v = 0; v < vertexCount; ++v) if (isAlone[v]) loneVertices.push(v);
    this.loneVertices = Uint32Array.from(loneVertices);
    this.sortedVertexLevel = Float32Array.from(this.vertexLevel).sort();
    this.sortedEdgeLevel = Float32Array.from(this.edgeLevel).sort();
    const number = new Uint32Array(vertexCount);
    this.loneVertices.forEach((v, i) => { number[v] = i; });
    const keep = new Uint8Array(vertexCount);
    for (const v of layer.medialPoints ?? []) keep[v] = 1;
    const n = this.loneVertices.length;
    this.held = Float32Array.from([...Array.from(this.loneVertices, (v) => held[v]!), Infinity]);
    this.ownLevel = Float32Array.from(this.loneVertices, (v) => own[v]!);
    this.keep = Uint8Array.from(this.loneVertices, (v) => keep[v]!);
    this.ends = new Uint32Array(2 * lone);
    this.endsNow = new Uint32Array(2 * lone);
    for (let i = 0; i < lone; ++i) for (const k of [0, 1]) this.ends[2 * i + k] = number[edges[2 * this.loneEdges[i]! + k]!]!;
    this.loneLevel = Float32Array.from(this.loneEdges, (e) => this.edgeLevel[e]!);
    this.loneFirst = Float32Array.from(this.loneEdges, (e) => this.first[e]!);
    [this.levelsAt, this.levels] = this.levelsOfCurves(isCurve);
    this.bare = new Float32Array(lone);
    this.loneThickness = Float32Array.from(this.loneEdges, (e) => this.thickness[e]!);
    this.loneLength = Float32Array.from(this.loneEdges, (e) => this.lengths[e]!);
    this.degree = new Uint32Array(n + 1);
    this.edgeXor = new Uint32Array(n + 1);
    this.out = new Uint8Array(n + 1);
    this.gone = new Uint8Array(lone);
    this.stack = new Uint32Array(2 * lone + 1);
    this.set = {
      faces: 0, triangles: 0, edges: 0, vertices: 0, area: 0, freeEnds: 0, level: 0,
      curves: { edge: new Uint32Array(lone), count: 0, length: 0 },
      boundary: { edge: new Uint32Array(rim), count: 0, length: 0 },
      seams: { edge: new Uint32Array(seam), count: 0, length: 0 },
      isolated: { vertex: new Uint32Array(loneVertices.length), count: 0 },
      pruned: new Uint8Array(vertexCount),
    };
  }

  /// The cells with level >= `level`, and of the curves what pruning at `theta1` leaves.
  compute(level: number, theta1: number): CellSet {
    const { set, degree, edgeXor, gone, out, ends, endsNow, loneLevel } = this, none = this.loneVertices.length;
    set.level = level;
    set.faces = this.layer.faceLevel ? countAtLeastDecreasing(this.layer.faceLevel, level) : this.layer.faceCount;
    set.triangles = this.triangleOffset[set.faces]!;
    set.area = this.areaBefore[set.faces]! - this.areaCut(set.faces, level);
    degree.fill(0);
    edgeXor.fill(0);
    gone.fill(0);
    out.fill(0);
    for (let i = 0, n = this.loneEdges.length; i < n; ++i) {
      if (loneLevel[i]! < level) continue;
      let a = ends[2 * i]!, b = ends[2 * i + 1]!;
      const [from, to] = this.bareAt(i, level);
      this.bare[i] = Math.max(0, to - from);
      if (to > from && from > 0) a = none;
      if (to > from && to < 1) b = none;
      endsNow[2 * i] = a;
      endsNow[2 * i + 1] = b;
      ++degree[a]!;
      ++degree[b]!;
      edgeXor[a]! ^= i;
      edgeXor[b]! ^= i;
    }
    const pruned = this.prune(level, theta1);
    set.pruned.fill(0);
    if (pruned > 0) for (let i = 0; i < out.length; ++i) if (out[i] && i < none) set.pruned[this.loneVertices[i]!] = 1;
    this.classify(level);
    set.vertices = countAtLeast(this.sortedVertexLevel, level) - pruned;
    set.edges = countAtLeast(this.sortedEdgeLevel, level) - pruned;
    return set;
  }

  /// Takes off free edges below theta1. With fixed keys any order gives the same, so a stack will do.
  private prune(level: number, theta1: number): number {
    const { loneThickness, bare, keep, gone } = this;
    return this.takeOff((v, i) => keep[v] === 0 && loneThickness[i]! < theta1 && bare[i]! > 0, level, gone);
  }

  private takeOff(may: (v: number, i: number) => boolean, level: number, mark: Uint8Array | null): number {
    const { degree, edgeXor, held, endsNow: ends, out, stack } = this;
    let height = 0, count = 0;
    for (let start = 0; start < degree.length; ++start) {
      if (degree[start] !== 1) continue;
      stack[height++] = start;
      while (height > 0) {
        const v = stack[--height]!;
        if (degree[v] !== 1 || held[v]! >= level) continue;
        const i = edgeXor[v]!;
        if (!may(v, i)) continue;
        const other = ends[2 * i] === v ? ends[2 * i + 1]! : ends[2 * i]!;
        if (mark) mark[i] = 1;
        out[v] = 1;
        ++count;
        degree[v] = 0;
        --degree[other]!;
        edgeXor[other]! ^= i;
        if (degree[other] === 1) stack[height++] = other;
      }
    }
    return count;
  }

  isVisible(v: number): boolean {
    return this.shownLevel[v]! >= this.set.level && !this.set.pruned[v];
  }

  private classify(level: number): void {
    const { set, degree, gone, first, second, third, lengths, loneLevel, bare, loneLength } = this;
    const { curves, boundary, seams } = set;
    curves.count = curves.length = boundary.count = boundary.length = seams.count = seams.length = 0;
    for (let i = 0, n = this.loneEdges.length; i < n; ++i) {
      if (gone[i] || loneLevel[i]! < level || bare[i] === 0) continue;
      curves.edge[curves.count++] = this.loneEdges[i]!;
      curves.length += loneLength[i]! * bare[i]!;
    }
    for (let i = 0, n = this.rimEdges.length; i < n; ++i) {
      const e = this.rimEdges[i]!;
      if (first[e]! < level || second[e]! >= level) continue;
      boundary.edge[boundary.count++] = e;
      boundary.length += lengths[e]!;
    }
    for (let i = 0, n = this.seamEdges.length; i < n; ++i) {
      const e = this.seamEdges[i]!;
      if (third[e]! < level) continue;
      seams.edge[seams.count++] = e;
      seams.length += lengths[e]!;
    }
    // Parts that coincide count once: a curve does not end with an edge of length zero.
    this.takeOff((_, i) => loneLength[i] === 0 && bare[i]! > 0, level, null);
    set.freeEnds = set.isolated.count = 0;
    for (let i = 0, n = this.loneVertices.length; i < n; ++i) {
      if (this.out[i] || this.held[i]! >= level) continue;
      // A spoke that one polygon has on both sides ends inside it: no free end.
      if (degree[i] === 1) set.freeEnds += Number(bare[this.edgeXor[i]!]! > 0);
      else if (degree[i] === 0 && this.ownLevel[i]! >= level) set.isolated.vertex[set.isolated.count++] = this.loneVertices[i]!;
    }
  }

  private polygonArea(begin: number, end: number): number {
    const { points, corners } = this.layer;
    const o = 3 * corners[begin]!;
    let x = 0, y = 0, z = 0;
    for (let i = begin + 1; i + 1 < end; ++i) {
      const a = 3 * corners[i]!, b = 3 * corners[i + 1]!;
      const ux = points[a]! - points[o]!, uy = points[a + 1]! - points[o + 1]!, uz = points[a + 2]! - points[o + 2]!;
      const vx = points[b]! - points[o]!, vy = points[b + 1]! - points[o + 1]!, vz = points[b + 2]! - points[o + 2]!;
      x += uy * vz - uz * vy;
      y += uz * vx - ux * vz;
      z += ux * vy - uy * vx;
    }
    return Math.hypot(x, y, z) / 2;
  }

  private levelsOfCurves(isCurve: Uint8Array): [Uint32Array, Float32Array] {
    const { edgeCount, faceCount, offsets, corners, sides, edges, cornerLevel } = this.layer, lone = this.loneEdges.length, at = new Uint32Array(lone + 1);
    if (!cornerLevel) return [at, new Float32Array(0)];
    const row = new Int32Array(edgeCount).fill(-1);
    this.loneEdges.forEach((e, i) => { if (isCurve[e]) row[e] = i; });
    for (const e of sides) if (row[e]! >= 0) ++at[row[e]! + 1]!;
    for (let i = 0; i < lone; ++i) at[i + 1]! += at[i]!;
    const levels = new Float32Array(2 * at[lone]!), next = at.slice();
    for (let f = 0; f < faceCount; ++f)
      for (let i = offsets[f]!, end = offsets[f + 1]!; i < end; ++i) {
        const r = row[sides[i]!]!;
        if (r < 0) continue;
        const k = 2 * next[r]!++, forward = edges[2 * sides[i]!] === corners[i] ? 0 : 1;
        levels[k + forward] = cornerLevel[i]!;
        levels[k + 1 - forward] = cornerLevel[i + 1 < end ? i + 1 : offsets[f]!]!;
      }
    return [at, levels];
  }

  private readonly stretch: [number, number] = [0, 1];
  /// From where to where on it a lone edge is off the sheets, as shares of its length. The levels of faces are linear along
  /// it, and they cover it where they are large enough.
  private bareAt(i: number, level: number): [number, number] {
    const { stretch, levels, levelsAt } = this;
    stretch[0] = 0;
    stretch[1] = 1;
    if (levelsAt[i] === levelsAt[i + 1]) {
      if (this.loneFirst[i]! >= level) stretch[1] = 0;
      return stretch;
    }
    for (let k = 2 * levelsAt[i]!; k < 2 * levelsAt[i + 1]!; k += 2) {
      const a = levels[k]!, b = levels[k + 1]!;
      if (a >= level && b >= level) stretch[1] = 0;
      else if (a >= level) stretch[0] = Math.max(stretch[0], Number.isFinite(a) ? (a - level) / (a - b) : 1);
      else if (b >= level) stretch[1] = Math.min(stretch[1], Number.isFinite(b) ? (level - a) / (b - a) : 0);
    }
    return stretch;
  }

  /// Of the first faces the area where the level, linear in the triangles of the fan, is less.
  private areaCut(faces: number, level: number): number {
    if (!this.leastCorner) return 0;
    const { offsets } = this.layer, levels = this.layer.cornerLevel!;
    let sum = 0;
    for (let f = 0; f < faces; ++f) {
      if (this.leastCorner[f]! >= level) continue;
      const o = offsets[f]!;
      for (let i = o + 1; i + 1 < offsets[f + 1]!; ++i) sum += this.triangleArea(o, i, i + 1) * shareBelow(levels[o]!, levels[i]!, levels[i + 1]!, level);
    }
    return sum;
  }

  private triangleArea(i: number, j: number, k: number): number {
    const { points, corners } = this.layer, o = 3 * corners[i]!, a = 3 * corners[j]!, b = 3 * corners[k]!;
    const ux = points[a]! - points[o]!, uy = points[a + 1]! - points[o + 1]!, uz = points[a + 2]! - points[o + 2]!;
    const vx = points[b]! - points[o]!, vy = points[b + 1]! - points[o + 1]!, vz = points[b + 2]! - points[o + 2]!;
    return Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx) / 2;
  }

  /// For histograms: area per face and length per curve edge beside the values the sliders compare.
  faceArea(f: number): number { return this.areaBefore[f + 1]! - this.areaBefore[f]!; }
  edgeLength(e: number): number { return this.lengths[e]!; }
}

/// The share of a triangle in which a linear function, given at its corners, is below a level.
export function shareBelow(a: number, b: number, c: number, level: number): number {
  const low = Math.min(a, b, c), high = Math.max(a, b, c), middle = a + b + c - low - high;
  if (low >= level) return 0;
  if (high < level) return 1;
  if (!Number.isFinite(high)) return middle >= level || !Number.isFinite(middle) ? 0 : 1;
  return middle >= level ? (level - low) ** 2 / ((middle - low) * (high - low)) : 1 - (high - level) ** 2 / ((high - low) * (high - middle));
}

/// How many of values in decreasing order are at least `level`.
export function countAtLeastDecreasing(values: Float32Array, level: number): number {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle]! >= level) low = middle + 1;
    else high = middle;
  }
  return low;
}

/// How many of values in increasing order are at least `level`.
export function countAtLeast(values: Float32Array, level: number): number {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle]! < level) low = middle + 1;
    else high = middle;
  }
  return values.length - low;
}
