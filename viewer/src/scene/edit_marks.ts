// SPDX-License-Identifier: Apache-2.0
// Where a tree was repaired, drawn over it: a dot each, a line from end to end, and a larger dot for the one that is
// stepped to.
import { Group, Vector3, type DataTexture } from "three";
import { EDIT_COLOURS, rgb, type EditGroup } from "../colours";
import { groupOf, type Tree } from "../tree";
import { Balls, Bars } from "./instances";
import { ballMaterial, barMaterial, vertexTexture, type SharedUniforms } from "./materials";
import type { Placement } from "./placement";

export class EditMarks {
  readonly group = new Group();
  readonly middles: Vector3[] = []; ///< scene units
  private readonly kinds: Record<EditGroup, { dots: Balls; lines: Bars; count: number }>;
  private readonly current: Balls;

  constructor(tree: Tree, placement: Placement, shared: SharedUniforms) {
    // Per repair its two ends and its middle.
    const n = tree.editCount, places: DataTexture = vertexTexture(3 * n, 4), data = places.image.data as Float32Array;
    const ends = new Float32Array(8 * n);
    placement.write(tree.editPoints, 4, ends);
    for (let i = 0; i < n; ++i) {
      data.set(ends.subarray(8 * i, 8 * i + 8), 12 * i);
      const middle = [0, 1, 2].map((k) => (ends[8 * i + k]! + ends[8 * i + 4 + k]!) / 2) as [number, number, number];
      data.set([...middle, 0], 12 * i + 8);
      this.middles.push(new Vector3(...middle));
    }
    const own = { vertexPlace: { value: places }, vertexValue: { value: vertexTexture(1, 1) }, vertexTime: { value: vertexTexture(1, 2) } };
    const always = { ...shared, burn: { value: shared.burn.value.clone().set(0, 0, 1, 0) } };
    const plain = (hex: string) => ({ plain: { value: new Vector3(...rgb(hex)) }, usePlain: { value: 1 }, onCurves: { value: 0 } });
    const ball = (hex: string) => new Balls(ballMaterial(always, { ...own, ...plain(hex), scale: { value: 1 }, fixedPixels: { value: 4 }, opacity: { value: 1 } }, false));
    const edges = Uint32Array.from({ length: 2 * n }, (_, i) => 3 * (i >> 1) + (i & 1));
    const of = (name: EditGroup) => {
      const list = Uint32Array.from({ length: n }, (_, i) => i).filter((i) => groupOf(tree.kind(i)) === name), hex = EDIT_COLOURS[name];
      const dots = ball(hex), lines = new Bars(barMaterial(always, { ...own, ...plain(hex), halfWidth: { value: 1.5 }, halfWorld: { value: 0 }, bias: { value: 4e-4 }, byPart: { value: 0 }, round_: { value: 0 }, opacity: { value: 1 } }, true));
      dots.write(list.map((i) => 3 * i + 2), list.length);
      lines.write(edges, list, list.length);
      return { dots, lines, count: list.length };
    };
    this.kinds = { bridges: of("bridges"), cuts: of("cuts"), leftOut: of("leftOut") };
    this.current = ball("ffb000");
    const meshes = [...Object.values(this.kinds).flatMap(({ dots, lines }) => [lines.mesh, dots.mesh]), this.current.mesh];
    meshes.forEach((mesh, i) => {
      mesh.material.depthTest = false;
      mesh.renderOrder = 3 + i;
      this.group.add(mesh);
    });
  }

  count(name: EditGroup): number { return this.kinds[name].count; }

  show(shown: Record<EditGroup, boolean>, edit: number, pixelRatio: number): void {
    const many = this.middles.length > 150;
    for (const name of ["bridges", "cuts", "leftOut"] as const) {
      const { dots, lines, count } = this.kinds[name];
      // Many small ones do not cover the tree.
      dots.mesh.material.uniforms.fixedPixels!.value = (many ? 2.4 : 3.8) * pixelRatio;
      lines.mesh.material.uniforms.halfWidth!.value = (many ? 0.8 : 1.3) * pixelRatio;
      dots.mesh.visible = lines.mesh.visible = shown[name] && count > 0;
    }
    this.current.write(edit >= 0 ? [3 * edit + 2] : [], Number(edit >= 0));
    this.current.mesh.material.uniforms.fixedPixels!.value = 6.5 * pixelRatio;
    this.current.mesh.visible = edit >= 0;
  }
}
