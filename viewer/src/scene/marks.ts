// SPDX-License-Identifier: Apache-2.0
// What picking draws: the maximal ball of a vertex, where it touches the boundary, and the ways there.
import { Group, Vector3, type DataTexture } from "three";
import { rgb } from "../colours";
import { Balls, Bars } from "./instances";
import { ballMaterial, barMaterial, vertexTexture, type SharedUniforms } from "./materials";

const MOST = 2047; // touching points drawn

export class Marks {
  readonly solid = new Group(); ///< drawn with the axis
  readonly glass = new Group(); ///< drawn over it
  private readonly places: DataTexture;
  private readonly centre: Balls;
  private readonly feet: Balls;
  private readonly spokes: Bars;
  private readonly ball: Balls;

  constructor(shared: SharedUniforms) {
    this.places = vertexTexture(TEXTURE_ROW, 4);
    const own = { vertexPlace: { value: this.places }, vertexValue: { value: vertexTexture(1, 1) }, vertexTime: { value: vertexTexture(1, 2) } };
    // No clipping and no fire for marks.
    const always = { ...shared, clipOn: { value: 0 }, burn: { value: shared.burn.value.clone().set(0, 0, 1, 0) } };
    const plain = (hex: string) => ({ plain: { value: new Vector3(...rgb(hex)) }, usePlain: { value: 1 }, onCurves: { value: 0 } });
    const ball = (hex: string, pixels: number, opacity: number) =>
      new Balls(ballMaterial(always, { ...own, ...plain(hex), scale: { value: 1 }, fixedPixels: { value: pixels }, opacity: { value: opacity } }, opacity < 1));
    this.centre = ball("ffb000", 7, 1);
    this.feet = ball("ffb000", 4.5, 1);
    this.spokes = new Bars(barMaterial(always, { ...own, ...plain("ffb000"), halfWidth: { value: 1 }, halfWorld: { value: 0 }, bias: { value: 1e-4 }, byPart: { value: 0 }, round_: { value: 0 }, opacity: { value: 1 } }, true));
    this.ball = ball("ffb000", 0, 0.16);
    if (shared.flat_.value) // over the curves
      for (const { mesh } of [this.spokes, this.feet, this.centre]) {
        mesh.material.depthTest = false;
        mesh.renderOrder = 5;
      }
    this.solid.add(this.centre.mesh, this.feet.mesh, this.spokes.mesh);
    this.glass.add(this.ball.mesh);
    this.clear();
  }

  clear(): void { this.solid.visible = this.glass.visible = false; }

  show(centre: Vector3, radius: number, feet: Vector3[], pixelRatio: number): void {
    const data = this.places.image.data as Float32Array;
    const n = Math.min(MOST, feet.length);
    [centre, ...feet.slice(0, n)].forEach((p, i) => data.set([p.x, p.y, p.z, i === 0 ? radius : 0], 4 * i));
    this.places.needsUpdate = true;
    const all = Uint32Array.from({ length: n }, (_, i) => i);
    this.centre.write([0], 1);
    this.feet.write(all.map((i) => i + 1), n);
    this.spokes.write(Uint32Array.from({ length: 2 * n }, (_, i) => (i % 2 ? (i + 1) / 2 : 0)), all, n);
    this.ball.write([0], radius > 0 ? 1 : 0);
    for (const [balls, pixels] of [[this.centre, 6], [this.feet, 4]] as const) balls.mesh.material.uniforms.fixedPixels!.value = pixels * pixelRatio;
    this.spokes.mesh.material.uniforms.halfWidth!.value = 0.9 * pixelRatio;
    this.solid.visible = this.glass.visible = true;
  }
}

const TEXTURE_ROW = 2048;
