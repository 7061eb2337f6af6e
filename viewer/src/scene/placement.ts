// SPDX-License-Identifier: Apache-2.0
// Scene units: the shape is centred and its longest side is 1, so shaders meet the same sizes for a cell and a mountain.
import { Vector3 } from "three";
import type { Meta } from "../data";

export class Placement {
  readonly centre: Vector3; ///< of the box, in page coordinates (world - origin)
  constructor(readonly meta: Meta) {
    const { low, high, origin } = meta;
    this.centre = new Vector3(...([0, 1, 2].map((k) => (low[k]! + high[k]!) / 2 - origin[k]!) as [number, number, number]));
  }
  get scale(): number { return 1 / this.meta.side; }

  /// World to scene and back.
  toScene(world: readonly number[]): Vector3 {
    return new Vector3(...([0, 1, 2].map((k) => world[k]! - this.meta.origin[k]!) as [number, number, number])).sub(this.centre).multiplyScalar(this.scale);
  }
  toWorld(scene: Vector3): [number, number, number] {
    const p = scene.clone().multiplyScalar(this.meta.side).add(this.centre);
    return [p.x + this.meta.origin[0], p.y + this.meta.origin[1], p.z + this.meta.origin[2]];
  }
  /// Half the extents of the box, scene units.
  get half(): Vector3 {
    const { low, high, side } = this.meta;
    return new Vector3((high[0] - low[0]) / 2 / side, (high[1] - low[1]) / 2 / side, (high[2] - low[2]) / 2 / side);
  }
  /// All points of an array, by page coordinates, to scene units with a fourth number per point.
  write(points: Float32Array, stride: number, out: Float32Array): void {
    const { x, y, z } = this.centre, s = this.scale;
    for (let i = 0, n = points.length / 3; i < n; ++i) {
      out[stride * i] = (points[3 * i]! - x) * s;
      out[stride * i + 1] = (points[3 * i + 1]! - y) * s;
      out[stride * i + 2] = (points[3 * i + 2]! - z) * s;
    }
  }
}
