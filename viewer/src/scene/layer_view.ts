// SPDX-License-Identifier: Apache-2.0
// A complex on the screen: sheets as one indexed geometry of which the first part is drawn, edges and curves as bars.
import { BufferAttribute, BufferGeometry, Group, Mesh, Vector3, type DataTexture, type RawShaderMaterial } from "three";
import { encode, rgb } from "../colours";
import type { Layer } from "../data";
import type { CellSet, LayerSets } from "../sets";
import type { State } from "../state";
import { Balls, Bars } from "./instances";
import { ballMaterial, barMaterial, surfaceMaterial, vertexTexture, type SharedUniforms } from "./materials";
import type { Placement } from "./placement";

export class LayerView {
  readonly group = new Group();
  readonly places: Float32Array; ///< x, y, z in scene units, radius
  private readonly values: DataTexture;
  private shown: string | null = null;
  private readonly surface: Mesh<BufferGeometry, RawShaderMaterial>;
  private readonly curves: Bars;
  private readonly boundary: Bars;
  private readonly seams: Bars;
  private readonly points: Balls;
  readonly union: Balls; ///< the balls of what is visible
  private readonly vertices: VertexTextures;

  constructor(readonly layer: Layer, sets: LayerSets, placement: Placement, shared: SharedUniforms) {
    const n = layer.vertexCount;
    const places = vertexTexture(n, 4);
    this.places = places.image.data as Float32Array;
    placement.write(layer.points, 4, this.places);
    const radius = layer.measures.get("radius");
    for (let v = 0; v < n; ++v) {
      const r = radius ? radius[v]! : 0;
      this.places[4 * v + 3] = Number.isFinite(r) ? r * placement.scale : 0;
    }
    this.values = vertexTexture(n, 1);
    const times = vertexTexture(n, 2);
    const burn = layer.measures.get("burn_time"), curveBurn = layer.measures.get("curve_burn_time");
    const timeData = times.image.data as Float32Array;
    for (let v = 0; v < n; ++v) {
      timeData[2 * v] = encode(burn ? burn[v]! : Infinity);
      timeData[2 * v + 1] = encode(curveBurn ? curveBurn[v]! : NaN);
    }
    this.vertices = { vertexPlace: { value: places }, vertexValue: { value: this.values }, vertexTime: { value: times } };
    const own = (more: Record<string, { value: unknown }>) => ({ ...this.vertices, ...more });
    const flag = () => ({ plain: { value: new Vector3() }, usePlain: { value: 0 } });

    const geometry = new BufferGeometry();
    geometry.setIndex(new BufferAttribute(triangulate(layer, sets.triangleOffset), 1));
    this.surface = new Mesh(geometry, surfaceMaterial(shared, own(flag())));
    const bar = (halfWidth: number, bias: number, round: number, opacity: number) =>
      new Bars(barMaterial(shared, own({ ...flag(), halfWidth: { value: halfWidth }, halfWorld: { value: 0 }, bias: { value: bias }, round_: { value: round }, opacity: { value: opacity }, onCurves: { value: round } }), round === 1));
    this.boundary = bar(0.8, 4e-5, 0, 1);
    this.seams = bar(1.1, 4e-5, 0, 1);
    this.curves = bar(2.5, 2e-4, 1, 1);
    const ball = (more: Record<string, { value: unknown }>) =>
      new Balls(ballMaterial(shared, own({ ...flag(), scale: { value: 1 }, fixedPixels: { value: 0 }, opacity: { value: 1 }, onCurves: { value: 0 }, ...more }), false));
    this.points = ball({ fixedPixels: { value: 5 }, onCurves: { value: 1 } });
    this.union = ball({});
    for (const mesh of [this.surface, this.boundary.mesh, this.seams.mesh, this.curves.mesh, this.points.mesh, this.union.mesh]) {
      mesh.frustumCulled = false;
      mesh.matrixAutoUpdate = false;
      this.group.add(mesh);
    }
  }

  /// The first faces, and the edges of the classes.
  show(set: CellSet): void {
    this.surface.geometry.setDrawRange(0, 3 * set.triangles);
    const edges = this.layer.edges;
    this.curves.write(edges, set.curves.edge, set.curves.count);
    this.boundary.write(edges, set.boundary.edge, set.boundary.count);
    this.seams.write(edges, set.seams.edge, set.seams.count);
    this.points.write(set.isolated.vertex, set.isolated.count);
  }

  colourBy(name: string): void {
    if (this.shown === name) return;
    this.shown = name;
    const values = this.layer.measures.get(name), data = this.values.image.data as Float32Array;
    if (!values) return;
    for (let v = 0; v < values.length; ++v) data[v] = encode(values[v]!);
    this.values.needsUpdate = true;
  }

  style(state: State, accent: string, pixelRatio: number, halfWorld: number): void {
    const plain = (mesh: Mesh<BufferGeometry, RawShaderMaterial>, hex: string, on: boolean) => {
      const uniforms = mesh.material.uniforms;
      (uniforms.plain!.value as Vector3).set(...rgb(hex));
      uniforms.usePlain!.value = Number(on);
    };
    const uniform = !this.layer.measures.has(state.color);
    plain(this.surface, state.dark ? "8fa3b8" : "a9bccf", uniform);
    plain(this.curves.mesh, accent, !state.curvesByMeasure || uniform);
    plain(this.points.mesh, accent, !state.curvesByMeasure || uniform);
    plain(this.boundary.mesh, state.dark ? "d5dae2" : "20242c", true);
    plain(this.seams.mesh, "0b0d12", true);
    plain(this.union.mesh, state.dark ? "9fb2c6" : "b9cada", uniform);
    this.surface.visible = state.sheets && !state.balls;
    this.boundary.mesh.visible = state.boundary && !state.balls;
    this.seams.mesh.visible = state.seams && !state.balls;
    this.curves.mesh.visible = state.curves && !state.balls;
    this.points.mesh.visible = state.points && !state.balls;
    this.union.mesh.visible = state.balls;
    this.curves.mesh.material.uniforms.halfWidth!.value = (state.curveWidth / 2) * pixelRatio;
    this.curves.mesh.material.uniforms.halfWorld!.value = halfWorld;
    this.boundary.mesh.material.uniforms.halfWidth!.value = 0.55 * pixelRatio;
    this.seams.mesh.material.uniforms.halfWidth!.value = 0.75 * pixelRatio;
    this.points.mesh.material.uniforms.fixedPixels!.value = (state.curveWidth / 2 + 2) * pixelRatio;
  }

  /// Lines of dense complexes would cover the sheets: the larger the share they would cover, the paler they are, so they
  /// come up when one goes near. `perPixel`: world units.
  fadeLines(set: CellSet, perPixel: number): void {
    for (const [bars, list, width] of [[this.boundary, set.boundary, 1.1], [this.seams, set.seams, 1.5]] as const) {
      const covered = set.area > 0 ? (list.length * width * perPixel) / set.area : 0;
      const opacity = Math.min(bars === this.seams ? 0.9 : 0.7, 0.012 / Math.max(covered, 1e-9));
      bars.mesh.material.uniforms.opacity!.value = opacity < 0.12 ? 0 : opacity;
    }
  }
}

type VertexTextures = Record<"vertexPlace" | "vertexValue" | "vertexTime", { value: DataTexture }>;

/// Fans of the polygons, in their order.
function triangulate(layer: Layer, offset: Uint32Array): Uint32Array<ArrayBuffer> {
  const { faceCount, offsets, corners } = layer;
  const triangles = new Uint32Array(3 * offset[faceCount]!);
  let n = 0;
  for (let f = 0; f < faceCount; ++f)
    for (let i = offsets[f]! + 1; i + 1 < offsets[f + 1]!; ++i) {
      triangles[n++] = corners[offsets[f]!]!;
      triangles[n++] = corners[i]!;
      triangles[n++] = corners[i + 1]!;
    }
  return triangles;
}
