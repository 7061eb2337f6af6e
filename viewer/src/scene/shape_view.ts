// SPDX-License-Identifier: Apache-2.0
// The surface of the shape as glass. Its nearest layer is drawn only: first depth, then colour.
import { BufferAttribute, BufferGeometry, Group, Mesh, Vector2, Vector3, type DepthTexture, type IUniform } from "three";
import { encode } from "../colours";
import type { Shape } from "../data";
import { colour, glassMaterial, skinMaterial, type SharedUniforms } from "./materials";
import type { Placement } from "./placement";

export class ShapeView {
  readonly group = new Group(); ///< as glass
  readonly solid = new Group(); ///< coloured, and not to be looked through
  /// Every so manieth vertex, for framing.
  readonly sample: Float32Array;
  private readonly own: Record<"opacity" | "tint" | "rim" | "behind" | "byValue" | "shapeRange", IUniform>;
  private readonly values: BufferAttribute;
  private readonly of: Uint32Array; ///< per vertex the point of the shape
  private shown: string | null = null;

  constructor(shape: Shape, placement: Placement, shared: SharedUniforms, depth: DepthTexture) {
    const given = new Float32Array(shape.points!.length);
    placement.write(shape.points!, 3, given);
    this.sample = given;
    const { points, normals, triangles, of } = creased(given, shape.triangles!, placement.meta.voxelSurface ? -1 : CREASE);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(points, 3));
    geometry.setAttribute("normal", new BufferAttribute(normals, 3));
    geometry.setIndex(new BufferAttribute(triangles, 1));
    this.of = of;
    this.values = new BufferAttribute(new Float32Array(of.length), 1);
    geometry.setAttribute("value", this.values);
    this.own = { opacity: { value: 0.5 }, tint: { value: new Vector3() }, rim: { value: new Vector3() }, behind: { value: depth }, byValue: { value: 0 }, shapeRange: { value: new Vector2(0, 1) } };
    const glass = glassMaterial({ ...shared, ...this.own });
    const before = glass.clone();
    before.uniforms = glass.uniforms;
    before.colorWrite = false;
    before.transparent = glass.transparent;
    const first = new Mesh(geometry, before), second = new Mesh(geometry, glass);
    first.renderOrder = 1;
    second.renderOrder = 2;
    for (const mesh of [first, second]) {
      mesh.frustumCulled = false;
      this.group.add(mesh);
    }
    const skin = new Mesh(geometry, skinMaterial({ ...shared, ...this.own }));
    skin.frustumCulled = false;
    this.solid.add(skin);
  }

  /// Values per point of the shape; null: none.
  colourBy(name: string, values: Float32Array | null, low: number, high: number): void {
    this.own.byValue.value = Number(values !== null);
    (this.own.shapeRange.value as Vector2).set(low, high);
    if (!values || this.shown === name) return;
    this.shown = name;
    this.of.forEach((point, v) => this.values.setX(v, encode(values[point]!)));
    this.values.needsUpdate = true;
  }

  style(dark: boolean, opacity: number): void {
    this.own.opacity.value = opacity * 1.2;
    (this.own.tint.value as Vector3).copy(colour(dark ? "8091a8" : "99a8bd"));
    (this.own.rim.value as Vector3).copy(colour(dark ? "c7d9f2" : "4d5e75"));
  }
}

const CREASE = Math.cos((35 * Math.PI) / 180);

/// `of`: per vertex the point it was.
interface Creased { points: Float32Array<ArrayBuffer>; normals: Float32Array<ArrayBuffer>; triangles: Uint32Array<ArrayBuffer>; of: Uint32Array }

/// Vertices with normals, weighted by area; where triangles meet at a crease (the cosine of its angle; -1: none), a vertex for each of its
/// sides.
export function creased(points: Float32Array, triangles: Uint32Array, crease = CREASE): Creased {
  const count = points.length / 3, corners = triangles.length, places: number[] = [];
  const out = Uint32Array.from(triangles), sums: number[] = new Array<number>(3 * count).fill(0);
  const begun = new Uint8Array(count), next: number[] = new Array<number>(count).fill(-1); // further vertices at the same place
  for (let t = 0; t + 2 < corners; t += 3) {
    const a = 3 * triangles[t]!, b = 3 * triangles[t + 1]!, c = 3 * triangles[t + 2]!;
    const ux = points[b]! - points[a]!, uy = points[b + 1]! - points[a + 1]!, uz = points[b + 2]! - points[a + 2]!;
    const vx = points[c]! - points[a]!, vy = points[c + 1]! - points[a + 1]!, vz = points[c + 2]! - points[a + 2]!;
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx, size = Math.hypot(x, y, z);
    for (let k = 0; k < 3; ++k) {
      let v = triangles[t + k]!;
      for (;;) {
        const sx = sums[3 * v]!, sy = sums[3 * v + 1]!, sz = sums[3 * v + 2]!;
        if (!begun[v] && v < count) {
          begun[v] = 1;
          break;
        }
        if (sx * x + sy * y + sz * z >= crease * size * Math.hypot(sx, sy, sz)) break;
        if (next[v] === -1) {
          const more = next.length;
          next[v] = more;
          next.push(-1);
          sums.push(0, 0, 0);
          places.push(triangles[t + k]!);
          v = more;
          break;
        }
        v = next[v]!;
      }
      out[t + k] = v;
      sums[3 * v]! += x;
      sums[3 * v + 1]! += y;
      sums[3 * v + 2]! += z;
    }
  }
  const all = new Float32Array(3 * (count + places.length)), normals = Float32Array.from(sums);
  all.set(points);
  places.forEach((v, i) => all.set(points.subarray(3 * v, 3 * v + 3), 3 * (count + i)));
  for (let i = 0; i < normals.length; i += 3) {
    const size = Math.hypot(normals[i]!, normals[i + 1]!, normals[i + 2]!) || 1;
    normals[i]! /= size;
    normals[i + 1]! /= size;
    normals[i + 2]! /= size;
  }
  return { points: all, normals, triangles: out, of: Uint32Array.from({ length: count + places.length }, (_, v) => (v < count ? v : places[v - count]!)) };
}
