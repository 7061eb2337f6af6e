// SPDX-License-Identifier: Apache-2.0
// A shape of the plane: its area in one colour under everything, and its outline.
import { BufferAttribute, BufferGeometry, Group, Mesh, Vector3 } from "three";
import type { Shape } from "../data";
import { Bars } from "./instances";
import { barMaterial, colour, fillMaterial, vertexTexture, type SharedUniforms } from "./materials";
import { outlineOf } from "./outline";
import type { Placement } from "./placement";

const HALF_WIDTH = 0.6; // pixels, of the outline
const COVERS = 0.15; // so much of the shape, before the outline pales

export class PlaneView {
  readonly group = new Group(); ///< the area
  readonly outline = new Group();
  readonly sample: Float32Array;
  private readonly bars: Bars;
  private readonly own = { tint: { value: new Vector3() }, opacity: { value: 0.5 } };
  private readonly rim = new Vector3();
  private area = 0;
  private length = 0;

  constructor(shape: Shape, placement: Placement, private readonly shared: SharedUniforms) {
    const count = shape.points!.length / 3, triangles = shape.triangles!, places = vertexTexture(count, 4), place = places.image.data as Float32Array;
    placement.write(shape.points!, 4, place);
    const points = new Float32Array(3 * count);
    placement.write(shape.points!, 3, points);
    this.sample = points;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(points, 3));
    geometry.setIndex(new BufferAttribute(Uint32Array.from(triangles), 1));
    this.group.add(new Mesh(geometry, fillMaterial(this.own)));
    // No fire on the outline.
    const still = { ...shared, burn: { value: shared.burn.value.clone().set(0, 0, 1, 0) } };
    const none = { vertexPlace: { value: places }, vertexValue: { value: vertexTexture(1, 1) }, vertexTime: { value: vertexTexture(1, 2) } };
    this.bars = new Bars(barMaterial(still, { ...none, plain: { value: new Vector3() }, usePlain: { value: 1 }, halfWidth: { value: 1 }, halfWorld: { value: 0 }, bias: { value: 0 }, byPart: { value: 0 }, round_: { value: 0 }, opacity: { value: 1 }, onCurves: { value: 0 } }, true));
    this.bars.mesh.material.depthTest = false;
    this.bars.mesh.renderOrder = 1; // over a union of disks, under the curves
    this.outline.add(this.bars.mesh);
    const edges = outlineOf(triangles, count), far = (a: number, b: number) => Math.hypot(place[4 * a]! - place[4 * b]!, place[4 * a + 1]! - place[4 * b + 1]!);
    this.bars.write(edges, Uint32Array.from({ length: edges.length / 2 }, (_, e) => e), edges.length / 2);
    for (let e = 0; e < edges.length; e += 2) {
      const a = 4 * edges[e]!, b = 4 * edges[e + 1]!;
      this.length += far(edges[e]!, edges[e + 1]!);
      this.area += (place[a]! * place[b + 1]! - place[b]! * place[a + 1]!) / 2;
    }
    for (const mesh of [this.group.children[0]!, this.bars.mesh]) mesh.frustumCulled = false;
  }

  style(dark: boolean, opacity: number): void {
    this.own.opacity.value = opacity;
    this.own.tint.value.copy(colour(dark ? "8091a8" : "99a8bd"));
    this.rim.copy(colour(dark ? "c7d9f2" : "4d5e75"));
  }

  /// Outlines of thin shapes would cover them: the larger the share, the paler they are. `perPixel`: scene units.
  fade(perPixel: number, pixelRatio: number): void {
    const strength = Math.min(1, (COVERS * Math.abs(this.area)) / Math.max(this.length * 2 * HALF_WIDTH * perPixel, 1e-300));
    const { plain, halfWidth } = this.bars.mesh.material.uniforms, { tint, opacity } = this.own;
    (plain!.value as Vector3).copy(this.shared.paper.value).lerp(tint.value, opacity.value).lerp(this.rim, strength);
    halfWidth!.value = HALF_WIDTH * pixelRatio;
  }
}
