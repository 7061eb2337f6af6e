// SPDX-License-Identifier: Apache-2.0
// The codes of arrays (FORMAT.md, "Codes"), and what pages leave out because it can be found.
import type { ArrayEntry, Numbers } from "./data";
import { PageError } from "./page_error";

const BYTES = { f32: 4, u32: 4, u16: 2, u8: 1 } as const;
const VIEWS = { f32: Float32Array, u32: Uint32Array, u16: Uint16Array, u8: Uint8Array } as const;

/// Bytes of an array in the data of the page.
export function bytesOf(a: ArrayEntry): number {
  return a.code === undefined ? BYTES[a.type] * a.components * a.count : (a.planes ?? 0) * a.components * a.count;
}

function refuse(a: ArrayEntry): never {
  throw new PageError(`The array ${a.name} of this page is described in a way its program does not know; write the page anew.`);
}

export function checkEntry(a: ArrayEntry): void {
  const whole = (n: unknown, most = Infinity) => Number.isInteger(n) && (n as number) >= 0 && (n as number) <= most;
  if (!BYTES[a.type] || !whole(a.count) || !whole(a.components) || !whole(a.offset) || a.offset % 4 !== 0) refuse(a);
  if (a.code === undefined) return;
  if (!["delta", "steps", "fresh", "again", "difference"].includes(a.code) || !whole(a.planes, 4)) refuse(a);
  if (a.code === "steps" && !(whole(a.bits, 24) && a.low?.length === a.components && a.step?.length === a.components)) refuse(a);
  if (a.code === "difference" && a.of?.length !== 2) refuse(a);
}

/// Words of their bytes, plane by plane.
function words(bytes: Uint8Array, planes: number, count: number): Uint32Array {
  const out = new Uint32Array(count);
  for (let p = 0; p < planes; ++p) {
    const from = p * count, shift = 8 * p;
    if (p === 0) for (let i = 0; i < count; ++i) out[i] = bytes[i]!;
    else for (let i = 0; i < count; ++i) out[i]! |= bytes[from + i]! << shift;
  }
  return out;
}

/// Sums of differences, by component.
function summed(out: Uint32Array, components: number): Uint32Array {
  for (let i = 0; i < out.length; ++i) {
    const z = out[i]!, d = (z >>> 1) ^ -(z & 1);
    out[i] = i < components ? d : (out[i - components]! + d) | 0;
  }
  return out;
}

/// All arrays as numbers; views of the bytes where they are as they are.
export function unpack(entries: ArrayEntry[], bytes: Uint8Array): Map<string, Numbers> {
  const arrays = new Map<string, Numbers>();
  const last: ArrayEntry[] = []; // those that need others
  for (const a of entries) {
    const n = a.count * a.components, begin = bytes.byteOffset + a.offset;
    if (a.code === undefined) {
      arrays.set(a.name, new VIEWS[a.type](bytes.buffer as ArrayBuffer, begin, n));
      continue;
    }
    if (a.code === "again" || a.code === "difference") {
      last.push(a);
      continue;
    }
    const out = words(bytes.subarray(a.offset, a.offset + bytesOf(a)), a.planes!, n);
    if (a.code === "delta") {
      summed(out, a.components);
      arrays.set(a.name, a.type === "f32" ? new Float32Array(out.buffer) : a.type === "u32" ? out : VIEWS[a.type].from(out));
    } else if (a.code === "fresh") {
      let next = 0;
      for (let i = 0; i < n; ++i) {
        out[i] = next - out[i]!;
        if (out[i] === next) ++next;
      }
      arrays.set(a.name, out);
    } else {
      const { components } = a, bits = a.bits!, mask = bits === 32 ? -1 : (1 << bits) - 1, infinite = mask >>> 0, nothing = infinite - 1;
      const values = new Float32Array(n);
      for (let k = 0; k < components; ++k) {
        const low = a.low![k]!, step = a.step![k]!;
        for (let i = k, code = 0; i < n; i += components) {
          const z = out[i]!;
          code = (code + ((z >>> 1) ^ -(z & 1))) & mask;
          values[i] = code === infinite ? Infinity : code === nothing ? NaN : low + step * code;
        }
      }
      arrays.set(a.name, values);
    }
  }
  for (const a of last) {
    const n = a.count * a.components;
    if (a.code === "difference") {
      const [first, second] = a.of!.map((name) => arrays.get(name));
      if (!(first instanceof Float32Array) || !(second instanceof Float32Array) || first.length !== n || second.length !== n) refuse(a);
      const values = new Float32Array(n);
      for (let i = 0; i < n; ++i) {
        const x = first[i]!;
        values[i] = Number.isFinite(x) ? Math.max(0, x - second[i]!) : x;
      }
      arrays.set(a.name, values);
      continue;
    }
    const layer = a.name.slice(0, a.name.lastIndexOf("/")), face = arrays.get(`${layer}/face_level`), offsets = arrays.get(`${layer}/polygon_offsets`);
    if (!(face instanceof Float32Array) || !(offsets instanceof Uint32Array) || offsets.length !== face.length + 1 || offsets[face.length] !== n) refuse(a);
    const corners = arrays.get(`${layer}/polygon_corners`);
    if (!(corners instanceof Uint32Array) || corners.length !== n) refuse(a);
    const out = words(bytes.subarray(a.offset, a.offset + bytesOf(a)), a.planes!, n), bits = new Uint32Array(face.buffer, face.byteOffset, face.length);
    const last = new Uint32Array(corners.reduce((most, v) => Math.max(most, v), 0) + 1).fill(0xffffffff);
    for (let f = 0; f < face.length; ++f)
      for (let i = offsets[f]!, most = bits[f]!; i < offsets[f + 1]!; ++i) {
        const z = out[i]!, v = corners[i]!;
        last[v] = out[i] = Math.min(most, last[v]!) + ((z >>> 1) ^ -(z & 1));
      }
    arrays.set(a.name, new Float32Array(out.buffer));
  }
  return arrays;
}

/// The sides of polygons as edges, each once, in the order in which they come around the polygons.
export function sidesOf(offsets: Uint32Array, corners: Uint32Array): { sides: Uint32Array; edges: Uint32Array } {
  const sides = new Uint32Array(corners.length), ends = new Uint32Array(2 * corners.length);
  let size = 16, count = 0;
  while (size < 2 * corners.length) size *= 2;
  const table = new Int32Array(size).fill(-1); // open addressing
  for (let f = 0; f + 1 < offsets.length; ++f)
    for (let i = offsets[f]!, end = offsets[f + 1]!; i < end; ++i) {
      const u = corners[i]!, v = corners[i + 1 < end ? i + 1 : offsets[f]!]!, a = Math.min(u, v), b = Math.max(u, v);
      let at = (Math.imul(a, 0x9e3779b1) ^ Math.imul(b, 0x85ebca6b)) >>> 0;
      for (at = (at ^ (at >>> 15)) & (size - 1); ; at = (at + 1) & (size - 1)) {
        const e = table[at]!;
        if (e < 0) {
          table[at] = count;
          ends[2 * count] = a;
          ends[2 * count + 1] = b;
          sides[i] = count++;
          break;
        }
        if (ends[2 * e] === a && ends[2 * e + 1] === b) {
          sides[i] = e;
          break;
        }
      }
    }
  return { sides, edges: ends.slice(0, 2 * count) };
}

/// Adds what a page leaves out of a layer: sides and edges of its polygons, and the levels of edges and vertices. Its
/// faces come in decreasing order of their (first) level then.
export function complete(layer: string, measures: string[], arrays: Map<string, Numbers>): void {
  const get = <T extends Numbers>(name: string, type: new (n: number) => T): T | null => {
    const found = arrays.get(`${layer}/${name}`);
    return found instanceof type ? (found as T) : null;
  };
  const put = (name: string, values: Numbers) => arrays.set(`${layer}/${name}`, values);
  const lone = get("lone_edges", Uint32Array), others = get("other_sides", Uint32Array), points = get("points", Float32Array);
  const corners = get("polygon_corners", Uint32Array), offsets = get("polygon_offsets", Uint32Array);
  if (!lone || !others || !points || !corners || !offsets) return;
  const damaged = (): never => { throw new PageError(`The cells of the layer ${layer} of this page do not fit together; the page is damaged.`); };
  const faces = Math.max(0, offsets.length - 1), vertices = points.length / 3;
  for (let f = 0; f < faces; ++f) if (offsets[f + 1]! < offsets[f]! || offsets[f + 1]! > corners.length) damaged();
  if (corners.some((v) => v >= vertices) || lone.some((v) => v >= vertices)) damaged();
  const { sides, edges } = sidesOf(offsets, corners), first = edges.length / 2, all = new Uint32Array(edges.length + lone.length);
  all.set(edges);
  all.set(lone, edges.length);
  for (let i = 0; i + 1 < others.length; i += 2) {
    if (others[i]! >= sides.length || others[i + 1]! >= lone.length / 2) damaged();
    sides[others[i]!] = first + others[i + 1]!;
  }
  put("edges", all);
  const count = all.length / 2;
  for (const suffix of ["", ...measures.map((m) => `/${m}`)]) {
    const face = get(`face_level${suffix}`, Float32Array);
    if (!face || face.length !== faces) continue;
    const edge = new Float32Array(count).fill(-Infinity), vertex = new Float32Array(vertices).fill(-Infinity);
    for (let f = 0; f < faces; ++f)
      for (let i = offsets[f]!, level = face[f]!; i < offsets[f + 1]!; ++i) if (level > edge[sides[i]!]!) edge[sides[i]!] = level;
    if (suffix === "") for (const e of get("curve_edges", Uint32Array) ?? []) edge[e] = Infinity;
    const settle = (levels: Float32Array, name: string) => {
      for (let i = 0; i < levels.length; ++i) if (levels[i] === -Infinity) levels[i] = Infinity;
      const rows = get(`${name}_rows${suffix}`, Uint32Array), values = get(`${name}_values${suffix}`, Float32Array);
      if (!rows || rows.length !== values?.length) return damaged();
      rows.forEach((row, i) => { levels[row] = values[i]!; });
      put(name + suffix, levels);
    };
    settle(edge, "edge_level");
    for (let e = 0; e < count; ++e)
      for (const v of [all[2 * e]!, all[2 * e + 1]!]) if (edge[e]! > vertex[v]!) vertex[v] = edge[e]!;
    settle(vertex, "vertex_level");
  }
  const level = get("face_level", Float32Array);
  if (!level) return void put("polygon_edges", sides);
  const order = byLevel(level), rows = new Uint32Array(faces + 1);
  for (let i = 0; i < faces; ++i) rows[i + 1] = rows[i]! + offsets[order[i]! + 1]! - offsets[order[i]!]!;
  const ofCorners = <T extends Uint32Array | Float32Array>(values: T, out: T): T => {
    for (let i = 0; i < faces; ++i) {
      const f = order[i]!, to = rows[i]!;
      for (let k = offsets[f]!, at = to; k < offsets[f + 1]!; ++k, ++at) out[at] = values[k]!;
    }
    return out;
  };
  put("polygon_corners", ofCorners(corners, new Uint32Array(corners.length)));
  put("polygon_edges", ofCorners(sides, new Uint32Array(sides.length)));
  const corner = get("corner_level", Float32Array);
  if (corner?.length === corners.length) put("corner_level", ofCorners(corner, new Float32Array(corner.length)));
  put("polygon_offsets", rows);
  for (const suffix of ["", ...measures.map((m) => `/${m}`)]) {
    const face = get(`face_level${suffix}`, Float32Array);
    if (face?.length === faces) put(`face_level${suffix}`, Float32Array.from(order, (f) => face[f]!));
  }
}

/// Rows in decreasing order of level; levels are not negative, so their bits are in their order.
function byLevel(level: Float32Array): Uint32Array {
  const bits = new Uint32Array(level.buffer, level.byteOffset, level.length), keys = new Float64Array(level.length), size = 2 ** 22;
  if (level.length > size) return Uint32Array.from(level.keys()).sort((a, b) => level[b]! - level[a]! || a - b);
  for (let i = 0; i < keys.length; ++i) keys[i] = (0x7f800000 - bits[i]!) * size + i;
  keys.sort();
  return Uint32Array.from(keys, (key) => key % size);
}
