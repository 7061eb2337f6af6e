// SPDX-License-Identifier: Apache-2.0
// The surface of the shape as glass. Its nearest layer is drawn only: first depth, then colour.
import { BufferAttribute, BufferGeometry, Group, Mesh, Vector3, type DepthTexture, type IUniform } from "three";
import type { Shape } from "../data";
import { colour, glassMaterial, type SharedUniforms } from "./materials";
import type { Placement } from "./placement";

export class ShapeView {
  readonly group = new Group();
  /// Every so manieth vertex, for framing.
  readonly sample: Float32Array;
  private readonly own: Record<"opacity" | "tint" | "rim" | "behind", IUniform>;

  constructor(shape: Shape, placement: Placement, shared: SharedUniforms, depth: DepthTexture) {
    const points = new Float32Array(shape.points!.length);
    placement.write(shape.points!, 3, points);
    this.sample = points;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(points, 3));
    geometry.setAttribute("normal", new BufferAttribute(normalsOf(points, shape.triangles!), 3));
    geometry.setIndex(new BufferAttribute(shape.triangles!, 1));
    this.own = { opacity: { value: 0.5 }, tint: { value: new Vector3() }, rim: { value: new Vector3() }, behind: { value: depth } };
    const { clipPlane, clipOn, perspective, viewport } = shared;
    const glass = glassMaterial({ ...this.own, clipPlane, clipOn, perspective, viewport });
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
  }

  style(dark: boolean, opacity: number): void {
    this.own.opacity.value = opacity * 1.2;
    (this.own.tint.value as Vector3).copy(colour(dark ? "8091a8" : "99a8bd"));
    (this.own.rim.value as Vector3).copy(colour(dark ? "c7d9f2" : "4d5e75"));
  }
}

/// Of vertices, weighted by area.
function normalsOf(points: Float32Array, triangles: Uint32Array): Float32Array<ArrayBuffer> {
  const normals = new Float32Array(points.length);
  for (let t = 0; t + 2 < triangles.length; t += 3) {
    const a = 3 * triangles[t]!, b = 3 * triangles[t + 1]!, c = 3 * triangles[t + 2]!;
    const ux = points[b]! - points[a]!, uy = points[b + 1]! - points[a + 1]!, uz = points[b + 2]! - points[a + 2]!;
    const vx = points[c]! - points[a]!, vy = points[c + 1]! - points[a + 1]!, vz = points[c + 2]! - points[a + 2]!;
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const i of [a, b, c]) {
      normals[i]! += x;
      normals[i + 1]! += y;
      normals[i + 2]! += z;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const size = Math.hypot(normals[i]!, normals[i + 1]!, normals[i + 2]!) || 1;
    normals[i]! /= size;
    normals[i + 1]! /= size;
    normals[i + 2]! /= size;
  }
  return normals;
}
