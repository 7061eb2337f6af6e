// SPDX-License-Identifier: Apache-2.0
// The outline of an area of triangles.

/// The sides of triangles that are not sides of others in the other direction, two vertices each: around the area, all
/// in the same sense.
export function outlineOf(triangles: Uint32Array, vertices: number): Uint32Array {
  const times = new Map<number, number>();
  for (let i = 0; i < triangles.length; ++i) {
    const a = triangles[i]!, b = triangles[i % 3 === 2 ? i - 2 : i + 1]!, key = Math.min(a, b) * vertices + Math.max(a, b);
    const sum = (times.get(key) ?? 0) + (a < b ? 1 : -1);
    if (sum === 0) times.delete(key);
    else times.set(key, sum);
  }
  const edges: number[] = [];
  for (const [key, sum] of times) {
    const low = Math.floor(key / vertices), high = key % vertices;
    for (let i = Math.abs(sum); i > 0; --i) edges.push(...(sum > 0 ? [low, high] : [high, low]));
  }
  return Uint32Array.from(edges);
}
