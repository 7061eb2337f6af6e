// SPDX-License-Identifier: Apache-2.0
// The union of the balls of what is visible: which of them to draw, and what share of the shape they fill.
import type { Layer, Meta, Shape } from "./data";
import type { CellSet, LayerSets } from "./sets";

const SLICE = 8; // milliseconds of work between frames

/// Of many balls those that matter to the eye. Balls of radius r whose centres are d apart leave dents of about
/// d^2 / 8r between them, so the larger they are the fewer are needed; those at rims and ends go first.
export function ballsToDraw(layer: Layer, sets: LayerSets, set: CellSet, meta: Meta, most: number): Uint32Array {
  const radius = layer.measures.get("radius");
  if (!radius) return new Uint32Array(0);
  const rim = new Uint8Array(layer.vertexCount);
  for (let i = 0; i < set.boundary.count; ++i) for (const k of [0, 1]) rim[layer.edges[2 * set.boundary.edge[i]! + k]!] = 1;
  const visible: number[] = [];
  for (let v = 0; v < layer.vertexCount; ++v) if (radius[v]! > 0 && Number.isFinite(radius[v]!) && sets.isVisible(v)) visible.push(v);
  const p = layer.points;
  for (let dent = 0.1 * (meta.voxel ?? meta.side / 256); ; dent *= 2) {
    const best = new Map<number, number>();
    const better = (v: number, w: number) => rim[v]! > rim[w]! || (rim[v] === rim[w] && radius[v]! > radius[w]!);
    for (const v of visible) {
      const level = Math.round(2 * Math.log2(Math.sqrt(8 * radius[v]! * dent) * 0.6)), cell = 2 ** (level / 2);
      const key = ((level & 31) * 1024 + (Math.floor(p[3 * v]! / cell) & 1023)) * 1048576 + (Math.floor(p[3 * v + 1]! / cell) & 1023) * 1024 + (Math.floor(p[3 * v + 2]! / cell) & 1023);
      const old = best.get(key);
      if (old === undefined || better(v, old)) best.set(key, v);
    }
    if (best.size <= most) return Uint32Array.from(best.values());
  }
}

/// The share of `shape/samples` inside the balls of visible vertices, or null without samples. Runs in slices; stops
/// when `cancelled` says so.
export async function shareInside(meta: Meta, shape: Shape, layer: Layer, sets: LayerSets, cancelled: () => boolean): Promise<number | null> {
  const radius = layer.measures.get("radius"), samples = shape.samples;
  if (!radius || !samples || samples.length === 0) return null;
  const visible: number[] = [];
  for (let v = 0; v < layer.vertexCount; ++v) if (radius[v]! > 0 && Number.isFinite(radius[v]!) && sets.isVisible(v)) visible.push(v);
  visible.sort((a, b) => radius[b]! - radius[a]!); // large ones first: they leave little to look at
  const left = new SampleGrid(meta, samples);
  let begin = performance.now();
  for (let i = 0; i < visible.length; ++i) {
    const v = visible[i]!;
    left.remove(layer.points[3 * v]!, layer.points[3 * v + 1]!, layer.points[3 * v + 2]!, radius[v]!);
    if ((i & 63) === 63 && performance.now() - begin > SLICE) {
      await new Promise((resolve) => setTimeout(resolve, 0));
      if (cancelled()) return null;
      begin = performance.now();
    }
  }
  return 1 - left.count / (samples.length / 3);
}

/// Samples in the cells of a grid; those inside a ball are taken out.
class SampleGrid {
  count: number;
  private readonly cells: number[][] = [];
  private readonly dims: number[];
  private readonly low: number[];
  private readonly h: number;
  constructor(meta: Meta, private readonly samples: Float32Array) {
    this.count = samples.length / 3;
    this.h = meta.side / Math.max(4, Math.min(48, Math.round(Math.cbrt(this.count))));
    this.low = meta.low.map((x, k) => x - meta.origin[k]!);
    this.dims = [0, 1, 2].map((k) => Math.max(1, Math.ceil((meta.high[k]! - meta.low[k]!) / this.h)));
    for (let i = 0; i < this.dims[0]! * this.dims[1]! * this.dims[2]!; ++i) this.cells.push([]);
    for (let i = 0; i < this.count; ++i) {
      const [a, b, c] = [0, 1, 2].map((k) => this.cellOf(samples[3 * i + k]!, k));
      this.cells[a! + this.dims[0]! * (b! + this.dims[1]! * c!)]!.push(i);
    }
  }
  private cellOf(x: number, k: number): number {
    return Math.min(this.dims[k]! - 1, Math.max(0, Math.floor((x - this.low[k]!) / this.h)));
  }
  remove(x: number, y: number, z: number, radius: number): void {
    const s = this.samples, limit = radius * radius;
    const [a0, a1] = [this.cellOf(x - radius, 0), this.cellOf(x + radius, 0)];
    const [b0, b1] = [this.cellOf(y - radius, 1), this.cellOf(y + radius, 1)];
    const [c0, c1] = [this.cellOf(z - radius, 2), this.cellOf(z + radius, 2)];
    for (let c = c0; c <= c1; ++c)
      for (let b = b0; b <= b1; ++b)
        for (let a = a0; a <= a1; ++a) {
          const cell = this.cells[a + this.dims[0]! * (b + this.dims[1]! * c)]!;
          for (let i = cell.length - 1; i >= 0; --i) {
            const j = 3 * cell[i]!;
            if ((s[j]! - x) ** 2 + (s[j + 1]! - y) ** 2 + (s[j + 2]! - z) ** 2 >= limit) continue;
            cell[i] = cell[cell.length - 1]!;
            cell.pop();
            --this.count;
          }
        }
  }
}
