// SPDX-License-Identifier: Apache-2.0
// A complex on the screen: sheets as one indexed geometry of which the first part is drawn, edges and curves as bars.
import { AlwaysDepth, BufferAttribute, BufferGeometry, Group, Mesh, Vector3, type DataTexture, type RawShaderMaterial } from "three";
import { encode, rgb } from "../colours";
import type { Layer } from "../data";
import type { CellSet, LayerSets } from "../sets";
import { sheetColumn } from "../measures";
import type { State } from "../state";
import { slabsOf } from "../slabs";
import { Balls, Bars } from "./instances";
import { ballMaterial, barMaterial, slabMaterial, surfaceMaterial, tubeMaterial, vertexTexture, type SharedUniforms } from "./materials";
import type { Placement } from "./placement";

export class LayerView {
  readonly group = new Group();
  readonly places: Float32Array; ///< x, y, z in scene units, radius
  private readonly values: DataTexture;
  private shown: string | null = null;
  private readonly branchRank: Int32Array | null;
  private part: Int32Array | null; ///< per edge, of what gives the colours
  private set: CellSet | null = null;
  private readonly tubes: Record<"all" | "picked" | "near", Bars> | null; ///< of a tree; what is picked, what the pointer is on
  private readonly path: Bars; ///< from what is picked to the root node
  private branch = -1;
  private sheet = -1;
  private readonly surface: Mesh<BufferGeometry, RawShaderMaterial>;
  private readonly curves: Bars;
  private readonly boundary: Bars;
  private readonly seams: Bars;
  private readonly points: Balls;
  private readonly junctions: Balls; ///< where seams meet
  private readonly picked: Bars; ///< the branch that is picked
  private readonly cuts: boolean; ///< fragments of sheets go by their level
  readonly union: Balls; ///< the balls of what is visible
  private readonly between: [Bars, Mesh<BufferGeometry, RawShaderMaterial>] | null; ///< of medial meshes: what is between balls, along edges and in triangles
  private readonly sheetRank: number[]; ///< per sheet its place by size, which gives its colour
  private readonly ofSheets: DataTexture | null; ///< values of sheets, by these places
  private readonly vertices: VertexTextures;
  private readonly flat: boolean; ///< in the plane

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

    const { edgeBranch } = layer, rank = edgeBranch ? ranks(edgeBranch, (e) => sets.edgeLength(e)) : [];
    this.branchRank = edgeBranch && edgeBranch.map((b) => (b < 0 ? -1 : rank[b]!));
    this.part = this.branchRank;
    this.cuts = layer.cornerLevel !== null && layer.faceLevel !== null && varies(layer);
    const byCorners = layer.sheet !== null || this.cuts;
    this.sheetRank = layer.sheet ? ranks(layer.sheet, (f) => sets.faceArea(f)) : [];
    this.ofSheets = layer.sheets ? vertexTexture(Math.max(layer.sheets.count, this.sheetRank.length), 1) : null;
    const geometry = byCorners ? cornersOf(layer, sets, this.places, this.cuts, this.sheetRank) : new BufferGeometry();
    if (!byCorners) geometry.setIndex(new BufferAttribute(triangulate(layer, sets.triangleOffset), 1));
    this.surface = new Mesh(geometry, surfaceMaterial(shared, own({ ...flag(), byPart: { value: 0 }, chosen: { value: -1 }, partValue: { value: this.ofSheets ?? this.values }, least: { value: -1 } }), byCorners));
    const bar = (halfWidth: number, bias: number, round: number, opacity: number) =>
      new Bars(barMaterial(shared, own({ ...flag(), halfWidth: { value: halfWidth }, halfWorld: { value: 0 }, bias: { value: bias }, byPart: { value: 0 }, round_: { value: round }, opacity: { value: opacity }, onCurves: { value: round } }), round === 1));
    this.boundary = bar(0.8, 4e-5, 0, 1);
    this.seams = bar(1.1, 4e-5, 0, 1);
    this.curves = bar(2.5, 2e-4, 1, 1);
    this.picked = bar(4, 4e-4, 1, 1);
    this.picked.mesh.material.depthFunc = AlwaysDepth; // seen through sheets
    this.picked.mesh.renderOrder = 1;
    this.path = bar(1.5, 4e-4, 0, 1);
    this.path.mesh.material.depthFunc = AlwaysDepth;
    this.path.mesh.renderOrder = 2;
    const tube = (more: number) => new Bars(tubeMaterial(shared, own({ ...flag(), halfWidth: { value: 0.6 }, more: { value: more }, byPart: { value: 0 } })));
    this.tubes = layer.tree && { all: tube(0), picked: tube(0.5), near: tube(1) };
    const ball = (more: Record<string, { value: unknown }>) =>
      new Balls(ballMaterial(shared, own({ ...flag(), scale: { value: 1 }, fixedPixels: { value: 0 }, opacity: { value: 1 }, onCurves: { value: 0 }, ...more }), false));
    this.points = ball({ fixedPixels: { value: 5 }, onCurves: { value: 1 } });
    this.junctions = ball({ fixedPixels: { value: 3 } });
    this.union = ball({});
    this.between = null;
    if (layer.collapses) {
      const { place, normal, corner } = slabsOf(layer, this.places), slabs = new BufferGeometry();
      slabs.setAttribute("position", new BufferAttribute(place, 3));
      slabs.setAttribute("normal", new BufferAttribute(normal, 3));
      slabs.setAttribute("corner", new BufferAttribute(corner, 1));
      const cones = tube(0);
      cones.write(layer.edges, Uint32Array.from({ length: layer.edgeCount }, (_, e) => e), layer.edgeCount);
      this.between = [cones, new Mesh(slabs, slabMaterial(shared, own({ ...flag(), least: { value: -1 } })))];
    }
    // In the plane all is in one depth: what is drawn last is seen.
    this.flat = shared.flat_.value > 0;
    if (this.flat)
      [this.curves.mesh, this.picked.mesh, this.points.mesh].forEach((mesh, i) => {
        mesh.material.depthTest = false;
        mesh.renderOrder = 2 + i;
      });
    for (const mesh of [this.surface, this.boundary.mesh, this.seams.mesh, this.curves.mesh, this.picked.mesh, this.path.mesh, this.points.mesh, this.junctions.mesh, this.union.mesh, ...(this.between ? [this.between[0].mesh, this.between[1]] : []), ...Object.values(this.tubes ?? {}).map((bars) => bars.mesh)]) {
      mesh.frustumCulled = false;
      mesh.matrixAutoUpdate = false;
      this.group.add(mesh);
    }
  }

  /// The first faces, and the edges of the classes.
  show(set: CellSet): void {
    this.surface.geometry.setDrawRange(0, 3 * set.triangles);
    // Rounding must not make holes in parts that are whole.
    this.surface.material.uniforms.least!.value = this.cuts ? set.level * (1 - 1e-5) : -1;
    const edges = this.layer.edges;
    this.set = set;
    this.writeCurves();
    this.boundary.write(edges, set.boundary.edge, set.boundary.count);
    this.seams.write(edges, set.seams.edge, set.seams.count);
    this.points.write(set.isolated.vertex, set.isolated.count);
    const degree = new Map<number, number>();
    if (this.layer.sheet)
      for (let i = 0; i < set.seams.count; ++i)
        for (const k of [0, 1]) {
          const v = edges[2 * set.seams.edge[i]! + k]!;
          degree.set(v, (degree.get(v) ?? 0) + 1);
        }
    const junctions = [...degree].filter(([, n]) => n > 2).map(([v]) => v);
    this.junctions.write(junctions, junctions.length);
  }

  private writeCurves(): void {
    const { edges } = this.layer, { edge, count } = this.set!.curves;
    this.curves.write(edges, edge, count, this.part);
    this.tubes?.all.write(edges, edge, count, this.part);
  }

  /// Edges of a tree that stand out, the way from there to the root node, and what the pointer is on.
  highlight(picked: Uint32Array, path: Uint32Array): void {
    const { edges } = this.layer;
    for (const bars of [this.picked, this.tubes!.picked]) bars.write(edges, picked, picked.length);
    this.path.write(edges, path, path.length);
  }
  showNear(list: Uint32Array): void {
    const { near } = this.tubes!;
    near.write(this.layer.edges, list, list.length);
    near.mesh.visible = list.length > 0;
  }

  /// The branch and the sheet that stand out; -1: none.
  pick(branch: number, sheet: number): void {
    if ((branch === this.branch && sheet === this.sheet) || this.layer.tree) return;
    this.branch = branch;
    this.sheet = sheet;
    const { edgeBranch, edges } = this.layer;
    const list = sheet >= 0 && this.layer.sheet ? this.around(sheet) : edgeBranch && branch >= 0 ? Uint32Array.from(edgeBranch.keys()).filter((e) => edgeBranch[e] === branch) : new Uint32Array(0);
    this.picked.write(edges, list, list.length);
    this.surface.material.uniforms.chosen!.value = sheet >= 0 ? (this.sheetRank[sheet] ?? -1) : -1;
  }

  /// Sheets, the largest first.
  sheetOrder(): number[] { return [...this.sheetRank.keys()].sort((a, b) => this.sheetRank[a]! - this.sheetRank[b]!); }

  /// The rims and seams of a sheet.
  private around(sheet: number): Uint32Array {
    const { faceCount, offsets, sides, sheet: sheets } = this.layer, times = new Map<number, number>();
    for (let f = 0; f < faceCount; ++f) if (sheets![f] === sheet) for (let i = offsets[f]!; i < offsets[f + 1]!; ++i) times.set(sides[i]!, (times.get(sides[i]!) ?? 0) + 1);
    return Uint32Array.from([...times].filter(([, n]) => n !== 2).map(([e]) => e));
  }

  dispose(): void {
    this.group.traverse((object) => {
      if (!(object instanceof Mesh)) return;
      (object.geometry as BufferGeometry).dispose();
      (object.material as RawShaderMaterial).dispose();
    });
    for (const { value } of Object.values(this.vertices)) value.dispose();
  }

  colourBy(name: string): void {
    if (this.shown === name) return;
    this.shown = name;
    const part = name === "branch" && this.branchRank && !this.layer.tree ? this.branchRank : (this.layer.parts.get(name) ?? null);
    if (part && part !== this.part && this.set) {
      this.part = part;
      this.writeCurves();
    }
    const column = sheetColumn(this.layer, name);
    if (column && this.ofSheets) {
      const values = this.ofSheets.image.data as Float32Array;
      this.sheetRank.forEach((rank, sheet) => { values[rank] = encode(column.values[sheet]!); });
      this.ofSheets.needsUpdate = true;
    }
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
    const ofSheets = sheetColumn(this.layer, state.color) !== undefined, bySheet = ofSheets || (state.color === "sheet" && this.layer.sheet !== null), byBranch = (state.color === "branch" && this.layer.branches !== null) || this.layer.parts.has(state.color);
    const uniform = !this.layer.measures.has(state.color);
    this.surface.material.uniforms.byPart!.value = ofSheets ? 2 : Number(bySheet);
    this.curves.mesh.material.uniforms.byPart!.value = Number(byBranch);
    plain(this.surface, state.dark ? "8fa3b8" : "a9bccf", uniform && !bySheet);
    plain(this.curves.mesh, accent, !byBranch && (!state.curvesByMeasure || uniform));
    plain(this.picked.mesh, "ffb000", true);
    plain(this.path.mesh, state.dark ? "ffffff" : "171b21", true);
    const lines = !this.tubes || !state.tubes;
    if (this.tubes) {
      const { all, picked, near } = this.tubes;
      plain(all.mesh, accent, !byBranch && uniform);
      plain(picked.mesh, "ffb000", true);
      plain(near.mesh, "ffd980", true);
      all.mesh.material.uniforms.byPart!.value = Number(byBranch);
      for (const { mesh } of [all, picked, near]) mesh.material.uniforms.halfWidth!.value = (state.tubes ? 0.6 : state.curveWidth / 2) * pixelRatio;
      for (const [bars, more] of [[picked, 0.5], [near, 1]] as const) bars.mesh.material.uniforms.more!.value = more * pixelRatio;
      all.mesh.visible = !lines && state.curves && !state.balls;
      picked.mesh.visible = !lines && !state.balls && picked.count > 0;
      near.mesh.visible = !state.balls && near.count > 0;
    }
    this.path.mesh.visible = !state.balls && this.path.count > 0;
    this.path.mesh.material.uniforms.halfWidth!.value = 1.1 * pixelRatio;
    plain(this.points.mesh, accent, !state.curvesByMeasure || uniform);
    plain(this.boundary.mesh, state.dark ? "d5dae2" : "20242c", true);
    plain(this.seams.mesh, "0b0d12", true);
    plain(this.junctions.mesh, "0b0d12", true);
    plain(this.union.mesh, state.dark ? "9fb2c6" : "b9cada", uniform);
    this.surface.visible = state.sheets && !state.balls;
    this.boundary.mesh.visible = state.boundary && !state.balls && !this.cuts; // the rim is inside the parts then
    this.seams.mesh.visible = state.seams && !state.balls;
    this.junctions.mesh.visible = this.seams.mesh.visible && Number(this.seams.mesh.material.uniforms.opacity!.value) > 0;
    this.curves.mesh.visible = lines && state.curves && !state.balls;
    this.picked.mesh.visible = !state.balls && this.picked.count > 0; // of tubes a line that is seen through others
    this.points.mesh.visible = state.points && !state.balls;
    this.union.mesh.visible = state.balls;
    for (const mesh of this.between ? [this.between[0].mesh, this.between[1]] : []) {
      mesh.visible = state.balls;
      plain(mesh, state.dark ? "9fb2c6" : "b9cada", uniform);
    }
    this.curves.mesh.material.uniforms.halfWidth!.value = (state.curveWidth / 2) * pixelRatio;
    this.curves.mesh.material.uniforms.halfWorld!.value = halfWorld;
    this.picked.mesh.material.uniforms.halfWidth!.value = (lines ? state.curveWidth / 2 + 2 : 1.1) * pixelRatio;
    this.picked.mesh.material.uniforms.halfWorld!.value = lines ? halfWorld : 0;
    this.boundary.mesh.material.uniforms.halfWidth!.value = 0.55 * pixelRatio;
    this.seams.mesh.material.uniforms.halfWidth!.value = 0.75 * pixelRatio;
    this.junctions.mesh.material.uniforms.fixedPixels!.value = 2.2 * pixelRatio;
    this.points.mesh.material.uniforms.fixedPixels!.value = (state.curveWidth / 2 + (this.flat ? 1 : 2)) * pixelRatio;
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

function varies(layer: Layer): boolean {
  const { offsets, cornerLevel, faceLevel } = layer;
  for (let f = 0; f < layer.faceCount; ++f)
    for (let i = offsets[f]!; i < offsets[f + 1]!; ++i) if (cornerLevel![i]! < faceLevel![f]!) return true;
  return false;
}

/// The same fans with what every corner has for itself: where `levels`, its level, else the number of its sheet and a
/// normal, smooth but across creases.
function cornersOf(layer: Layer, sets: LayerSets, places: Float32Array, levels: boolean, rank: number[]): BufferGeometry {
  const offset = sets.triangleOffset, { faceCount, offsets, corners } = layer, n = 3 * offset[faceCount]!;
  const vertex = new Uint32Array(n), other = new Float32Array(n), normals = levels ? null : creasedNormals(layer, places);
  const normal = new Float32Array(normals ? 3 * n : 0);
  let at = 0;
  for (let f = 0; f < faceCount; ++f)
    for (let i = offsets[f]! + 1; i + 1 < offsets[f + 1]!; ++i)
      for (const k of [offsets[f]!, i, i + 1]) {
        vertex[at] = corners[k]!;
        other[at] = levels ? Math.min(layer.cornerLevel![k]!, 1e30) : rank[layer.sheet![f]!]!;
        if (normals) normal.set(normals.subarray(3 * k, 3 * k + 3), 3 * at);
        ++at;
      }
  const geometry = new BufferGeometry();
  geometry.setAttribute("corner", new BufferAttribute(vertex, 1));
  geometry.setAttribute(levels ? "level" : "part", new BufferAttribute(other, 1));
  if (normals) geometry.setAttribute("normal", new BufferAttribute(normal, 3));
  return geometry;
}

/// Per part its place when parts are sorted by size, largest first: those have colours of their own.
export function ranks(partOf: ArrayLike<number>, size: (i: number) => number): number[] {
  const sizes: number[] = [], rank: number[] = [];
  for (let i = 0; i < partOf.length; ++i) if (partOf[i]! >= 0) sizes[partOf[i]!] = (sizes[partOf[i]!] ?? 0) + size(i);
  [...sizes.keys()].sort((a, b) => (sizes[b] ?? 0) - (sizes[a] ?? 0) || a - b).forEach((part, place) => { rank[part] = place; });
  return rank;
}

const CREASE = Math.cos((35 * Math.PI) / 180);

/// Per corner of a polygon the mean of the normals of the polygons of its sheet at the vertex that turn off by less than
/// a crease. Sheets have no sides: the others are turned round where they look the other way.
function creasedNormals(layer: Layer, places: Float32Array): Float32Array {
  const { faceCount, offsets, corners, sheet } = layer, ofFace = new Float32Array(3 * faceCount);
  const first = new Int32Array(layer.vertexCount).fill(-1), next = new Int32Array(corners.length), faceOf = new Uint32Array(corners.length);
  for (let f = 0; f < faceCount; ++f) {
    const o = 4 * corners[offsets[f]!]!;
    for (let i = offsets[f]!; i < offsets[f + 1]!; ++i) {
      faceOf[i] = f;
      next[i] = first[corners[i]!]!;
      first[corners[i]!] = i;
      if (i === offsets[f] || i + 1 === offsets[f + 1]) continue;
      const a = 4 * corners[i]!, b = 4 * corners[i + 1]!;
      const ux = places[a]! - places[o]!, uy = places[a + 1]! - places[o + 1]!, uz = places[a + 2]! - places[o + 2]!;
      const vx = places[b]! - places[o]!, vy = places[b + 1]! - places[o + 1]!, vz = places[b + 2]! - places[o + 2]!;
      ofFace[3 * f]! += uy * vz - uz * vy;
      ofFace[3 * f + 1]! += uz * vx - ux * vz;
      ofFace[3 * f + 2]! += ux * vy - uy * vx;
    }
  }
  const normals = new Float32Array(3 * corners.length);
  for (let i = 0; i < corners.length; ++i) {
    const f = faceOf[i]!, x = ofFace[3 * f]!, y = ofFace[3 * f + 1]!, z = ofFace[3 * f + 2]!, size = Math.hypot(x, y, z);
    if (size === 0) continue;
    let sx = 0, sy = 0, sz = 0;
    for (let k = first[corners[i]!]!; k >= 0; k = next[k]!) {
      const g = faceOf[k]!;
      if (sheet![g] !== sheet![f]) continue;
      const gx = ofFace[3 * g]!, gy = ofFace[3 * g + 1]!, gz = ofFace[3 * g + 2]!, dot = x * gx + y * gy + z * gz;
      if (Math.abs(dot) < CREASE * size * Math.hypot(gx, gy, gz)) continue;
      const sign = dot < 0 ? -1 : 1;
      sx += sign * gx;
      sy += sign * gy;
      sz += sign * gz;
    }
    const length = Math.hypot(sx, sy, sz) || 1;
    normals[3 * i] = sx / length;
    normals[3 * i + 1] = sy / length;
    normals[3 * i + 2] = sz / length;
  }
  return normals;
}
