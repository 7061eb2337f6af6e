// SPDX-License-Identifier: Apache-2.0
// From a line of sight to a vertex, and from a vertex to where its ball touches the boundary.
import type { Meta, Shape } from "./data";
import type { CellSet, LayerSets } from "./sets";

export interface Ray {
  origin: [number, number, number];
  direction: [number, number, number]; ///< of length 1
  /// How far off the line at unit distance counts as hit (perspective), and in all (orthographic).
  spread: number;
  width: number;
}

/// What is hit: its nearest vertex, and the edge where it is a curve, the face where it is a sheet (else -1).
export interface Hit { vertex: number; edge: number; face: number }

/// Coordinates of the layer with `stride` numbers per vertex, in the units of the ray. `keep` says what is not cut away.
export function pickVertex(ray: Ray, places: Float32Array, stride: number, sets: LayerSets, set: CellSet, sheets: boolean, curves: boolean, keep: (x: number, y: number, z: number) => boolean): Hit | null {
  const { offsets, corners, edges } = sets.layer;
  const [ox, oy, oz] = ray.origin, [dx, dy, dz] = ray.direction;
  let best = Infinity, hit: Hit | null = null;
  const nearest = (candidates: Iterable<number>, x: number, y: number, z: number) => {
    let least = Infinity, found = 0;
    for (const v of candidates) {
      const far = (places[stride * v]! - x) ** 2 + (places[stride * v + 1]! - y) ** 2 + (places[stride * v + 2]! - z) ** 2;
      if (far < least) [least, found] = [far, v];
    }
    return found;
  };
  if (sheets)
    for (let f = 0; f < set.faces; ++f) {
      const begin = offsets[f]!, end = offsets[f + 1]!, a = stride * corners[begin]!;
      const ax = places[a]!, ay = places[a + 1]!, az = places[a + 2]!;
      for (let i = begin + 1; i + 1 < end; ++i) {
        const b = stride * corners[i]!, c = stride * corners[i + 1]!;
        const ux = places[b]! - ax, uy = places[b + 1]! - ay, uz = places[b + 2]! - az;
        const vx = places[c]! - ax, vy = places[c + 1]! - ay, vz = places[c + 2]! - az;
        const px = dy * vz - dz * vy, py = dz * vx - dx * vz, pz = dx * vy - dy * vx;
        const det = ux * px + uy * py + uz * pz;
        if (det === 0) continue;
        const sx = ox - ax, sy = oy - ay, sz = oz - az;
        const u = (sx * px + sy * py + sz * pz) / det;
        if (!(u >= 0 && u <= 1)) continue;
        const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
        const v = (dx * qx + dy * qy + dz * qz) / det;
        if (!(v >= 0 && u + v <= 1)) continue;
        const t = (vx * qx + vy * qy + vz * qz) / det;
        if (!(t > 0 && t < best)) continue;
        const x = ox + t * dx, y = oy + t * dy, z = oz + t * dz;
        if (!keep(x, y, z)) continue;
        best = t;
        hit = { vertex: nearest(corners.subarray(begin, end), x, y, z), edge: -1, face: f };
      }
    }
  // Curves are drawn thick: near is enough, and they win over a sheet they lie on.
  const offer = (x: number, y: number, z: number, candidates: Iterable<number>, edge: number) => {
    const t = (x - ox) * dx + (y - oy) * dy + (z - oz) * dz;
    const tolerance = ray.width + ray.spread * t;
    if (!(t > 0) || t - 2 * tolerance >= best || !keep(x, y, z)) return;
    if (Math.hypot(x - ox - t * dx, y - oy - t * dy, z - oz - t * dz) > tolerance) return;
    best = t;
    hit = { vertex: nearest(candidates, x, y, z), edge, face: -1 };
  };
  if (curves) {
    const lists = [set.curves];
    for (const list of lists)
      for (let i = 0; i < list.count; ++i) {
        const a = edges[2 * list.edge[i]!]!, b = edges[2 * list.edge[i]! + 1]!;
        const ax = places[stride * a]!, ay = places[stride * a + 1]!, az = places[stride * a + 2]!;
        const ux = places[stride * b]! - ax, uy = places[stride * b + 1]! - ay, uz = places[stride * b + 2]! - az;
        // Nearest points of a segment and a line.
        const along = ux * dx + uy * dy + uz * dz, size = ux * ux + uy * uy + uz * uz;
        const wx = ox - ax, wy = oy - ay, wz = oz - az;
        const across = size - along * along;
        let s = across > 1e-12 * size ? (ux * wx + uy * wy + uz * wz - along * (dx * wx + dy * wy + dz * wz)) / across : 0.5;
        s = Math.min(1, Math.max(0, s));
        offer(ax + s * ux, ay + s * uy, az + s * uz, [a, b], list.edge[i]!);
      }
    for (let i = 0; i < set.isolated.count; ++i) {
      const v = set.isolated.vertex[i]!;
      offer(places[stride * v]!, places[stride * v + 1]!, places[stride * v + 2]!, [v], -1);
    }
  }
  return hit;
}

/// The triangle that is hit first, and the weights of its corners there. Places have three numbers.
export function pickTriangle(ray: Ray, places: Float32Array, triangles: Uint32Array, keep: (x: number, y: number, z: number) => boolean): { triangle: number; weights: [number, number, number] } | null {
  const [ox, oy, oz] = ray.origin, [dx, dy, dz] = ray.direction;
  let best = Infinity, hit: { triangle: number; weights: [number, number, number] } | null = null;
  for (let i = 0; i + 2 < triangles.length; i += 3) {
    const a = 3 * triangles[i]!, b = 3 * triangles[i + 1]!, c = 3 * triangles[i + 2]!;
    const ax = places[a]!, ay = places[a + 1]!, az = places[a + 2]!;
    const ux = places[b]! - ax, uy = places[b + 1]! - ay, uz = places[b + 2]! - az, vx = places[c]! - ax, vy = places[c + 1]! - ay, vz = places[c + 2]! - az;
    const px = dy * vz - dz * vy, py = dz * vx - dx * vz, pz = dx * vy - dy * vx, det = ux * px + uy * py + uz * pz;
    if (det === 0) continue;
    const sx = ox - ax, sy = oy - ay, sz = oz - az, u = (sx * px + sy * py + sz * pz) / det;
    if (!(u >= 0 && u <= 1)) continue;
    const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux, v = (dx * qx + dy * qy + dz * qz) / det;
    if (!(v >= 0 && u + v <= 1)) continue;
    const t = (vx * qx + vy * qy + vz * qz) / det;
    if (!(t > 0 && t < best) || !keep(ox + t * dx, oy + t * dy, oz + t * dz)) continue;
    best = t;
    hit = { triangle: i / 3, weights: [1 - u - v, u, v] };
  }
  return hit;
}

/// The edge whose tube is hit first. Places have four numbers, the fourth the radius; thin tubes are hit beside, too.
export function pickTube(ray: Ray, places: Float32Array, edges: Uint32Array, keep: (x: number, y: number, z: number) => boolean): number {
  const [ox, oy, oz] = ray.origin, [dx, dy, dz] = ray.direction;
  let best = Infinity, hit = -1;
  for (let e = 0; 2 * e < edges.length; ++e) {
    const a = 4 * edges[2 * e]!, b = 4 * edges[2 * e + 1]!;
    const ax = places[a]! - ox, ay = places[a + 1]! - oy, az = places[a + 2]! - oz;
    const ux = places[b]! - places[a]!, uy = places[b + 1]! - places[a + 1]!, uz = places[b + 2]! - places[a + 2]!;
    // Nearest points of a segment and a line.
    const along = ux * dx + uy * dy + uz * dz, size = ux * ux + uy * uy + uz * uz, across = size - along * along;
    const first = ax * dx + ay * dy + az * dz;
    let s = across > 1e-12 * size ? (along * first - (ux * ax + uy * ay + uz * az)) / across : 0.5;
    s = Math.min(1, Math.max(0, s));
    const x = ax + s * ux, y = ay + s * uy, z = az + s * uz, t = x * dx + y * dy + z * dz;
    if (!(t > 0)) continue;
    const off = Math.max(0, x * x + y * y + z * z - t * t), radius = places[a + 3]! + s * (places[b + 3]! - places[a + 3]!), least = ray.width + ray.spread * t;
    if (off > Math.max(radius, least) ** 2) continue;
    const at = t - Math.sqrt(Math.max(0, radius * radius - off)) + (off > radius * radius ? least : 0); // what is hit itself wins
    if (at < best && keep(ox + x, oy + y, oz + z)) {
      best = at;
      hit = e;
    }
  }
  return hit;
}

const SAME = Math.cos((14 * Math.PI) / 180);

/// Where a ball of a fitted axis touches the surface that is drawn: the nearest points of its triangles, at most half a
/// voxel farther than the radius, one for all that lie in about the same direction. World positions.
function touchingSurface({ origin, voxel, side }: Meta, points: Float32Array, triangles: Uint32Array, world: readonly [number, number, number], radius: number): [number, number, number][] {
  const limit = radius + 0.5 * (voxel ?? side / 512), [px, py, pz] = world.map((x, k) => x - origin[k]!) as [number, number, number];
  const near: { at: [number, number, number]; far: number }[] = [];
  for (let t = 0; t + 2 < triangles.length; t += 3) {
    const a = 3 * triangles[t]!, b = 3 * triangles[t + 1]!, c = 3 * triangles[t + 2]!;
    if (Math.min(Math.abs(points[a]! - px), Math.abs(points[b]! - px), Math.abs(points[c]! - px)) > limit && (points[a]! - px) * (points[b]! - px) > 0 && (points[a]! - px) * (points[c]! - px) > 0) continue;
    const [x, y, z] = nearestInTriangle(points, a, b, c, px, py, pz), far = Math.hypot(x - px, y - py, z - pz);
    if (far <= limit) near.push({ at: [x, y, z], far });
  }
  near.sort((u, v) => u.far - v.far);
  const found: { at: [number, number, number]; far: number }[] = [];
  for (const one of near) {
    const turned = ({ at, far }: (typeof near)[0]) => ((at[0] - px) * (one.at[0] - px) + (at[1] - py) * (one.at[1] - py) + (at[2] - pz) * (one.at[2] - pz)) < SAME * far * one.far;
    if (found.every(turned)) found.push(one);
  }
  return found.map(({ at }) => [at[0] + origin[0], at[1] + origin[1], at[2] + origin[2]]);
}

/// Ericson, Real-Time Collision Detection, 5.1.5. `a`, `b`, `c`: where the corners begin in `points`.
function nearestInTriangle(points: Float32Array, a: number, b: number, c: number, px: number, py: number, pz: number): [number, number, number] {
  const ax = points[a]!, ay = points[a + 1]!, az = points[a + 2]!;
  const ux = points[b]! - ax, uy = points[b + 1]! - ay, uz = points[b + 2]! - az, vx = points[c]! - ax, vy = points[c + 1]! - ay, vz = points[c + 2]! - az;
  const wx = px - ax, wy = py - ay, wz = pz - az;
  const at = (s: number, t: number): [number, number, number] => [ax + s * ux + t * vx, ay + s * uy + t * vy, az + s * uz + t * vz];
  const d1 = ux * wx + uy * wy + uz * wz, d2 = vx * wx + vy * wy + vz * wz;
  if (d1 <= 0 && d2 <= 0) return at(0, 0);
  const uu = ux * ux + uy * uy + uz * uz, uv = ux * vx + uy * vy + uz * vz, vv = vx * vx + vy * vy + vz * vz;
  const d3 = d1 - uu, d4 = d2 - uv, d5 = d1 - uv, d6 = d2 - vv;
  if (d3 >= 0 && d4 <= d3) return at(1, 0);
  const vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return at(d1 / (d1 - d3), 0);
  if (d6 >= 0 && d5 <= d6) return at(0, 1);
  const vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return at(0, d2 / (d2 - d6));
  const va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const t = (d4 - d3) / (d4 - d3 + (d5 - d6));
    return at(1 - t, t);
  }
  const sum = va + vb + vc;
  return sum > 0 ? at(vb / sum, vc / sum) : at(0, 0);
}

/// World positions of the boundary sites a ball touches: at most a hundred-thousandth of the radius farther, and as far
/// as float32 coordinates are off.
export function touchingSites(meta: Meta, shape: Shape, world: readonly [number, number, number], radius: number): [number, number, number][] {
  const m = meta.sites_to_world, sites = shape.sites;
  if (!Number.isFinite(radius)) return [];
  if (!sites && shape.points && shape.triangles && !meta.plane) return touchingSurface(meta, shape.points, shape.triangles, world, radius);
  if (!m || !sites) return [];
  const tiny = 3e-7 * Math.max(meta.side, ...meta.low.map((x, k) => Math.max(Math.abs(x - meta.origin[k]!), Math.abs(meta.high[k]! - meta.origin[k]!))));
  const limit = (radius * (1 + 1e-5) + tiny) ** 2;
  const [x, y, z] = world;
  const found: [number, number, number][] = [];
  for (let i = 0; i + 2 < sites.length; i += 3) {
    const a = sites[i]!, b = sites[i + 1]!, c = sites[i + 2]!;
    const sx = m[0]! * a + m[1]! * b + m[2]! * c + m[3]!;
    const ex = sx - x;
    if (ex * ex > limit) continue;
    const sy = m[4]! * a + m[5]! * b + m[6]! * c + m[7]!, sz = m[8]! * a + m[9]! * b + m[10]! * c + m[11]!;
    if (ex * ex + (sy - y) ** 2 + (sz - z) ** 2 <= limit) found.push([sx, sy, sz]);
  }
  return found;
}
