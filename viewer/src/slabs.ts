// SPDX-License-Identifier: Apache-2.0
// The slabs of a medial mesh: of each triangle the two planes that touch the balls of its corners.
import type { Layer } from "./data";

/// Two triangles where three balls have common tangent planes, none where one lies in what the others span. Places have
/// four numbers, the fourth the radius.
export function slabsOf(layer: Layer, places: Float32Array): { place: Float32Array<ArrayBuffer>; normal: Float32Array<ArrayBuffer>; corner: Uint32Array<ArrayBuffer> } {
  const place: number[] = [], normal: number[] = [], corner: number[] = [], { corners } = layer;
  for (let f = 0; f < layer.faceCount; ++f) {
    const of = [corners[3 * f]!, corners[3 * f + 1]!, corners[3 * f + 2]!], [a, b, c] = of.map((v) => 4 * v) as [number, number, number];
    const u = [0, 1, 2].map((k) => places[b + k]! - places[a + k]!), v = [0, 1, 2].map((k) => places[c + k]! - places[a + k]!);
    const du = places[a + 3]! - places[b + 3]!, dv = places[a + 3]! - places[c + 3]!; // what n u and n v are
    const dot = (x: number[], y: number[]) => x[0]! * y[0]! + x[1]! * y[1]! + x[2]! * y[2]!;
    const uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
    if (!(det > 0)) continue;
    const s = (du * vv - dv * uv) / det, t = (dv * uu - du * uv) / det, flat = [0, 1, 2].map((k) => s * u[k]! + t * v[k]!), rest = 1 - dot(flat, flat);
    if (!(rest > 0)) continue;
    const across = [u[1]! * v[2]! - u[2]! * v[1]!, u[2]! * v[0]! - u[0]! * v[2]!, u[0]! * v[1]! - u[1]! * v[0]!], size = Math.sqrt(rest / det);
    for (const sign of [1, -1]) {
      const n = [0, 1, 2].map((k) => flat[k]! + sign * size * across[k]!);
      for (const w of of) {
        for (let k = 0; k < 3; ++k) place.push(places[4 * w + k]! + places[4 * w + 3]! * n[k]!);
        normal.push(...n);
        corner.push(w);
      }
    }
  }
  return { place: Float32Array.from(place), normal: Float32Array.from(normal), corner: Uint32Array.from(corner) };
}
