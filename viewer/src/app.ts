// SPDX-License-Identifier: Apache-2.0
// The state of the page and what follows from it. Changes are collected; what depends on them is done once per frame.
import { Vector3 } from "three";
import { ballsToDraw, shareInside } from "./balls";
import { CATEGORICAL, MAPS, textureOf } from "./colours";
import { commandOf } from "./command";
import { byMeasure, type Layer, type LayerName, type Page } from "./data";
import { isCategory, rangeOf, sheetColumn, UNIFORM, valuesOf, type Range } from "./measures";
import { pickTriangle, pickTube, pickVertex, touchingSites, type Ray } from "./pick";
import { EditMarks } from "./scene/edit_marks";
import { LayerView } from "./scene/layer_view";
import { Marks } from "./scene/marks";
import { Placement } from "./scene/placement";
import { PlaneView } from "./scene/plane_view";
import { ShapeView } from "./scene/shape_view";
import { Stage } from "./scene/stage";
import { LayerSets, type CellSet } from "./sets";
import { keyOf, layerOf, sanitize, type Camera, type State } from "./state";
import { groupOf, type Rows, type Tree } from "./tree";

/// Figures of what is visible.
export interface Numbers {
  faces: number;
  area: number;
  curveEdges: number;
  curveLength: number;
  freeEnds: number;
  isolated: number;
  vertices: number;
  edges: number;
  boundaryEdges: number;
  seamEdges: number;
}

export interface Picked {
  layer: LayerName;
  vertex: number;
  branch: number; ///< that the curve is of that was hit; -1: none
  sheet: number; ///< that was hit; -1: none
  position: [number, number, number];
  radius: number;
  measures: Record<string, number>;
  touching: [number, number, number][];
}

interface Shown { sets: LayerSets; view: LayerView; set: CellSet; ranges: Map<string, Range> }

const MOST_BALLS = 6000;
const FLIGHT = 350; ///< milliseconds

export class App {
  state: State;
  readonly placement: Placement;
  readonly marks: Marks;
  readonly glass: ShapeView | null = null; ///< the shape around
  readonly edits: EditMarks | null = null; ///< where the tree was repaired
  near = -1; ///< the branch of the tree that the pointer is on
  onNear: (branch: number, x: number, y: number) => void = () => {};
  onMoved: () => void = () => {};
  private flight = 0;
  readonly figure: PlaneView | null = null; ///< the same in the plane
  picked: Picked | null = null;
  onChange: (numbers: Numbers) => void = () => {};
  onDrawn: () => void = () => {};
  onShare: (text: string) => void = () => {};
  onPick: (picked: Picked | null) => void = () => {};
  private readonly layers = new Map<string, Shown>(); ///< by name; of the core one per measure it was pruned by
  private applied: State | null = null;
  private balls = { wanted: 0, timer: 0 };

  constructor(readonly page: Page, readonly stage: Stage, state: State) {
    const { meta, shape } = page;
    this.placement = new Placement(meta);
    this.state = sanitize(state, page);
    stage.plane = meta.plane ? (meta.yDown ? "down" : "up") : null;
    this.marks = new Marks(stage.shared);
    stage.add(this.marks.solid);
    stage.add(this.marks.glass, stage.overlay);
    if (shape.points && shape.triangles && meta.plane) {
      this.figure = new PlaneView(shape, this.placement, stage.shared);
      stage.add(this.figure.group, stage.paper);
      stage.add(this.figure.outline);
    } else if (shape.points && shape.triangles) {
      this.glass = new ShapeView(shape, this.placement, stage.shared, stage.depth);
      stage.add(this.glass.group, stage.overlay);
      stage.add(this.glass.solid);
    }
    if (this.tree && this.tree.editCount > 0) {
      this.edits = new EditMarks(this.tree, this.placement, stage.shared);
      stage.add(this.edits.group, stage.overlay);
    }
    stage.onFrame = () => {
      this.update();
      this.onDrawn();
    };
  }

  set(change: Partial<State>): void {
    const before = this.state, key = this.key();
    const other = change.measure !== undefined && change.measure !== before.measure; // with a threshold of its own
    this.state = sanitize({ ...before, ...(other ? { threshold: NaN } : {}), ...change }, this.page);
    // A range belongs to its measure.
    if (change.surface !== undefined && change.surface !== before.surface && this.state.surface !== UNIFORM) Object.assign(this.state, { shape: true, shapeOpacity: change.shapeOpacity ?? 1 }); // colours want to be seen
    if (change.surface === UNIFORM && before.surface !== UNIFORM && change.shapeOpacity === undefined && before.shapeOpacity === 1) this.state.shapeOpacity = 0.5;
    if (before.color !== this.state.color && change.rangeLow === undefined && change.rangeHigh === undefined) this.state.rangeLow = this.state.rangeHigh = NaN;
    if (key !== this.key()) this.clearPick();
    this.stage.invalidate();
  }

  get tree(): Tree | null { return this.page.layers.get("tree")?.tree ?? null; }
  private get byCategory(): boolean { return isCategory(layerOf(this.page, this.state), this.state.color); }

  shown(): Shown {
    const key = this.key();
    return this.layers.get(key) ?? this.ensure(key, byMeasure(layerOf(this.page, this.state), this.state.measure));
  }
  private ensure(key: string, layer: Layer): Shown {
    let shown = this.layers.get(key);
    if (!shown) {
      const sets = new LayerSets(layer);
      const view = new LayerView(layer, sets, this.placement, this.stage.shared);
      this.stage.add(view.group);
      shown = { sets, view, set: sets.compute(0, 0), ranges: new Map() };
      this.layers.set(key, shown);
      if (layer.collapses) this.leave(key);
    }
    return shown;
  }
  /// Of medial meshes two views are kept: with none there, the card would forget their programs.
  private leave(key: string): void {
    const old = [...this.layers.keys()].filter((k) => k.startsWith("simple/") && k !== key);
    for (const k of old.slice(0, -1)) {
      const { view } = this.layers.get(k)!;
      view.group.removeFromParent();
      view.dispose();
      this.layers.delete(k);
    }
  }
  private key(): string {
    const { layer, measure, vertices } = this.state;
    return layer === "core" ? `core/${measure}` : layer === "simple" ? `simple/${vertices}` : keyOf(this.page, this.state);
  }

  /// The sets of a layer of the page, for sliders; null until there is time for them, after the first picture.
  setsOf(name: "core" | "family"): LayerSets | null {
    const key = name === "core" ? `core/${this.state.measure}` : name;
    const layer = this.page.layers.get(name), known = this.layers.get(key)?.sets;
    if (known || !layer || !this.slidersReady) return known ?? null;
    return this.ensure(key, byMeasure(layer, this.state.measure)).sets;
  }
  /// Sliders show what they cut: that takes a while, and is done after the first picture.
  slidersReady = false;

  /// The range of a measure of the layer shown.
  range(name = this.state.color): Range | null {
    const shown = this.shown(), { layer } = shown.sets, values = layer.collapses && name === "radius" ? layer.collapses.radii : valuesOf(layer, name);
    if (!values) return null;
    let range = shown.ranges.get(name);
    if (!range) {
      // Of a skeleton the range is that of what the page starts with: most of the family is noise near zero.
      range = rangeOf(values);
      const asked = this.page.layers.get("skeleton");
      const first = this.state.layer === "skeleton" && asked ? this.rangeAsked(asked, name) : range;
      if (first.finite > 0) range = { ...range, centralLow: first.centralLow, centralHigh: first.centralHigh };
      shown.ranges.set(name, range);
    }
    return range;
  }

  /// Of the skeleton that was asked for: a measure of sheets or of curves on these only.
  private rangeAsked(layer: Layer, measure: string): Range {
    const values = layer.measures.get(measure), { branches } = layer;
    if (!values) return rangeOf(new Float32Array(0));
    const included = new Uint8Array(layer.vertexCount);
    const curves = measure.startsWith("curve_"), sheets = measure === "erosion_thickness" || measure === "burn_time";
    if (branches && (!sheets || layer.faceCount === 0)) for (const v of branches.points) included[v] = 1;
    if (!curves || !branches) for (const v of layer.corners) included[v] = 1;
    return rangeOf(values, included);
  }

  /// The range of colours: as set, else nearly all values, from zero where that is near.
  colourRange(): [number, number] {
    const range = this.range();
    if (!range || range.finite === 0 || this.byCategory) return [0, 1];
    let low = range.centralLow > 0 && range.centralLow < 0.3 * range.centralHigh ? 0 : range.centralLow, high = range.centralHigh;
    if (!(high > low)) [low, high] = [range.low, range.high];
    return [Number.isFinite(this.state.rangeLow) ? this.state.rangeLow : low, Number.isFinite(this.state.rangeHigh) ? this.state.rangeHigh : high];
  }

  /// The range of nearly all values on what is visible.
  visibleRange(): [number, number] | null {
    const { sets } = this.shown(), values = valuesOf(sets.layer, this.state.color);
    if (!values) return null;
    if (!sets.layer.measures.has(this.state.color)) {
      const all = rangeOf(values); // of sheets
      return all.finite > 0 ? [all.low, all.high] : null;
    }
    this.update();
    const range = rangeOf(values, Uint8Array.from(values, (_, v) => Number(sets.isVisible(v))));
    return range.finite > 0 ? [range.centralLow, range.centralHigh] : null;
  }

  /// Everything that follows from the state; only what changed is done.
  update(): void {
    this.shown().view.fadeLines(this.shown().set, this.stage.camera.perPixel * this.page.meta.side);
    this.figure?.fade(this.stage.camera.perPixel, this.stage.pixelRatio);
    const s = this.state, old = this.applied;
    if (old === s) return;
    this.applied = s;
    const changed = (...keys: (keyof State)[]) => !old || keys.some((key) => !Object.is(old[key], s[key]));
    const shown = this.shown(), { view } = shown, shared = this.stage.shared;
    if (changed("layer", "measure", "theta1", "theta2", "threshold", "vertices")) {
      const family = keyOf(this.page, s) === "family";
      shown.sets.compute(s.layer === "core" ? s.threshold : family ? s.theta2 : 0, family ? s.theta1 : 0);
      view.show(shown.set);
      this.ballsChanged();
    }
    if (changed("balls")) this.ballsChanged();
    for (const [key, other] of this.layers) other.view.group.visible = key === this.key();
    view.colourBy(s.color);
    view.pick(s.branch, s.sheet);
    if (s.layer === "tree" && changed("layer", "axis", "branch", "rows")) this.highlight();
    this.edits?.show(s, s.edit, this.stage.pixelRatio);
    if (this.edits) this.edits.group.visible = s.layer === "tree";
    if (changed("map", "color", "layer")) {
      for (const [{ value }, parts] of [[shared.colourMap, this.byCategory], [shared.shapeMap, false]] as const) {
        (value.image as unknown as { data: Uint8Array }).data.set(textureOf(s.map, parts));
        value.needsUpdate = true;
      }
    }
    shared.range.value.set(...this.colourRange());
    const map = MAPS[s.map] ?? MAPS.viridis!;
    const accent = s.map === "diverging" && s.dark ? "ffffff" : map.accent;
    const byMeasure = s.curvesByMeasure || s.color.startsWith("curve_");
    view.style(byMeasure ? { ...s, curvesByMeasure: true } : s, accent, this.stage.pixelRatio, this.page.meta.plane ? 0 : 0.0016);
    this.stage.setPaper(s.dark);
    const around = this.glass ?? this.figure;
    around?.style(s.dark, s.shapeOpacity);
    this.glass?.colourBy(s.surface, this.page.shape.measures.get(s.surface) ?? null, ...this.surfaceRange());
    if (around) around.group.visible = s.shape && s.shapeOpacity > 0 && !this.surfaceIsSolid;
    if (this.glass) this.glass.solid.visible = this.surfaceIsSolid;
    if (this.figure) this.figure.outline.visible = s.shape;
    this.figure?.fade(this.stage.camera.perPixel, this.stage.pixelRatio);
    this.stage.camera.orthographic = s.orthographic;
    this.clip();
    const width = this.page.meta.side * 0.012;
    shared.burn.value.set(Number(s.burn), s.time, width, Number(s.burnHides));
    this.onChange(this.numbers());
  }

  /// The coloured surface hides what is inside.
  get surfaceIsSolid(): boolean { const s = this.state; return s.shape && s.surface !== UNIFORM && s.shapeOpacity > 0.98 && this.glass !== null; }

  /// Whether something is drawn in the colours of the measure, for which there is a bar then.
  get isColoured(): boolean {
    const s = this.state, { sets: { layer }, set } = this.shown(), atVertices = layer.measures.has(s.color);
    if (s.balls) return atVertices;
    if (s.sheets && set.faces > 0 && (atVertices || sheetColumn(layer, s.color) !== undefined)) return true;
    if (!atVertices) return false;
    const byMeasure = s.curvesByMeasure || s.color.startsWith("curve_") || (layer.tree !== null && s.tubes);
    return byMeasure && ((s.curves && set.curves.count > 0) || (s.points && set.isolated.count > 0));
  }

  /// The largest sheets of what is shown, by what they are called; those have colours of their own.
  sheetNames(): string[] {
    const { sheet } = layerOf(this.page, this.state), order = this.shown().view.sheetOrder();
    return sheet ? order.slice(0, CATEGORICAL.length).map((s) => `sheet ${s}`) : [];
  }

  private readonly surfaceRanges = new Map<string, Range>();
  /// Of the values that the shape is coloured by; null: of none.
  surfaceValues(name = this.state.surface): Range | null {
    const values = this.page.shape.measures.get(name);
    if (!values) return null;
    const range = this.surfaceRanges.get(name) ?? rangeOf(values);
    this.surfaceRanges.set(name, range);
    return range;
  }
  surfaceRange(): [number, number] {
    const range = this.surfaceValues();
    if (!range || range.finite === 0) return [0, 1];
    const low = range.centralLow > 0 && range.centralLow < 0.3 * range.centralHigh ? 0 : range.centralLow;
    return range.centralHigh > low ? [low, range.centralHigh] : [range.low, range.high];
  }

  private clip(): void {
    const s = this.state, { clipPlane, clipOn } = this.stage.shared, half = this.placement.half;
    clipOn.value = Number(s.clip);
    const axis = s.clipAxis === "view" ? this.stage.camera.forward.negate() : new Vector3(Number(s.clipAxis === "x"), Number(s.clipAxis === "y"), Number(s.clipAxis === "z"));
    const reach = Math.abs(axis.x) * half.x + Math.abs(axis.y) * half.y + Math.abs(axis.z) * half.z;
    const sign = s.clipFlip ? -1 : 1;
    const at = (2 * s.clipAt - 1) * reach * 1.001;
    clipPlane.value.set(sign * axis.x, sign * axis.y, sign * axis.z, -sign * at);
  }

  numbers(): Numbers {
    const { set } = this.shown();
    return {
      faces: set.faces, area: set.area, curveEdges: set.curves.count, curveLength: set.curves.length, freeEnds: set.freeEnds,
      isolated: set.isolated.count, vertices: set.vertices, edges: set.edges, boundaryEdges: set.boundary.count, seamEdges: set.seams.count,
    };
  }

  command(): string { return commandOf(this.page, this.state); }

  /// The last and first moment of the burning of the layer shown.
  burnRange(): [number, number] | null {
    const range = this.range("burn_time"), curves = this.range("curve_burn_time");
    if (!range || range.finite === 0) return null;
    return [range.low, Math.max(range.high, curves && curves.finite > 0 ? curves.high : 0)];
  }

  private ballsChanged(): void {
    const ticket = ++this.balls.wanted;
    window.clearTimeout(this.balls.timer);
    if (!this.state.balls) {
      this.onShare("");
      return;
    }
    const shown = this.shown(), { layer } = shown.sets;
    const balls = this.page.meta.plane ? "disks" : "balls";
    if (!layer.measures.has("radius")) return this.onShare(`No radii in this page: no ${balls}.`);
    if (layer.collapses) {
      shown.view.union.write(Uint32Array.from({ length: layer.vertexCount }, (_, v) => v), layer.vertexCount);
      return this.onShare("The envelope of the mesh: its balls, and what is between them.");
    }
    this.onShare(`Union of ${balls}: counting …`);
    // Not while a slider moves.
    this.balls.timer = window.setTimeout(async () => {
      const list = ballsToDraw(layer, shown.sets, shown.set, this.page.meta, MOST_BALLS);
      shown.view.union.write(list, list.length);
      this.stage.invalidate();
      const share = await shareInside(this.page.meta, this.page.shape, layer, shown.sets, () => ticket !== this.balls.wanted);
      if (ticket !== this.balls.wanted) return;
      this.onShare(share === null ? `The ${balls} of what is visible.` : `The ${balls} of what is visible fill ${(100 * share).toFixed(1)} % of the shape.`);
    }, shown.view.union.count === 0 ? 0 : 120);
  }

  // Picking.

  private rayAt(x: number, y: number): Ray {
    const { camera, width, height } = this.stage;
    const three = camera.apply();
    const near = new Vector3((x / width) * 2 - 1, 1 - (y / height) * 2, -1).unproject(three);
    const far = new Vector3((x / width) * 2 - 1, 1 - (y / height) * 2, 1).unproject(three);
    const direction = far.sub(near).normalize();
    const start = camera.orthographic ? near : camera.position;
    const pixels = this.state.curveWidth / 2 + 4;
    return {
      origin: start.toArray(), direction: direction.toArray(),
      spread: camera.orthographic ? 0 : (pixels * camera.perPixel) / camera.distance, width: camera.orthographic ? pixels * camera.perPixel : 0,
    };
  }
  private get keep(): (x: number, y: number, z: number) => boolean {
    const plane = this.stage.shared.clipPlane.value;
    return this.state.clip ? (a, b, c) => plane.x * a + plane.y * b + plane.z * c + plane.w <= 0 : () => true;
  }

  pickAt(x: number, y: number): void {
    const s = this.state, ray = this.rayAt(x, y), { keep } = this;
    if (s.layer === "tree") {
      const branch = this.branchAt(x, y);
      if (branch < 0) return this.clearPick();
      return this.set({ branch, axis: this.tree!.branchAxis[branch]!, rows: s.rows === "branches" ? "branches" : "axes" });
    }
    if (this.surfaceIsSolid) return this.pickSurface(ray);
    const { sets, set, view } = this.shown();
    const hit = pickVertex(ray, view.places, 4, sets, set, s.sheets, s.curves, keep);
    if (hit === null) this.clearPick();
    else this.pick(hit.vertex, this.state.layer, hit.edge < 0 ? -1 : (sets.layer.edgeBranch?.[hit.edge] ?? -1), hit.face < 0 ? -1 : (sets.layer.sheet?.[hit.face] ?? -1));
  }

  /// A place on the surface, with what it is coloured by there.
  private pickSurface(ray: Ray): void {
    this.clearPick();
    const { points, triangles, measures } = this.page.shape, hit = pickTriangle(ray, this.glass!.sample, triangles!, this.keep);
    if (!hit) return;
    const { origin } = this.page.meta, at = (values: Float32Array, stride: number, k: number) => [0, 1, 2].reduce((sum, i) => sum + hit.weights[i]! * values[stride * triangles![3 * hit.triangle + i]! + k]!, 0);
    const position = [0, 1, 2].map((k) => at(points!, 3, k) + origin[k]!) as [number, number, number];
    this.marks.show(this.placement.toScene(position), 0, [], this.stage.pixelRatio);
    this.picked = { layer: this.state.layer, vertex: -1, branch: -1, sheet: -1, position, radius: NaN, measures: Object.fromEntries([...measures].map(([name, values]) => [name, at(values, 1, 0)])), touching: [] };
    this.onPick(this.picked);
    this.stage.invalidate();
  }

  pick(vertex: number, name = this.state.layer, branch = -1, sheet = -1): Picked {
    if (name !== this.state.layer) this.set({ layer: name });
    const { sets } = this.shown(), { layer } = sets;
    if (!(Number.isInteger(vertex) && vertex >= 0 && vertex < layer.vertexCount)) throw new RangeError(`There is no vertex ${vertex}.`);
    const { origin } = this.page.meta;
    const position = [0, 1, 2].map((k) => layer.points[3 * vertex + k]! + origin[k]!) as [number, number, number];
    const measures: Record<string, number> = {};
    for (const [measure, values] of layer.measures) measures[measure] = values[vertex]!;
    const radius = measures.radius ?? NaN;
    const touching = touchingSites(this.page.meta, this.page.shape, position, radius);
    this.picked = { layer: name, vertex, branch, sheet, position, radius, measures, touching };
    this.set({ branch, sheet, ...(sheet >= 0 && layer.sheets ? { list: "sheets" } : branch >= 0 ? { list: "branches" } : {}) });
    this.marks.show(this.placement.toScene(position), Number.isFinite(radius) ? radius * this.placement.scale : 0, touching.map((p) => this.placement.toScene(p)), this.stage.pixelRatio);
    this.onPick(this.picked);
    this.stage.invalidate();
    return this.picked;
  }

  /// A branch by its number, as a row of the table; -1: none.
  pickBranch(branch: number): void {
    this.clearPick();
    this.set({ branch });
  }

  /// A sheet by its number; -1: none.
  pickSheet(sheet: number): void {
    this.clearPick();
    this.set({ sheet });
  }

  clearPick(): void {
    this.state = { ...this.state, branch: -1, sheet: -1, axis: -1, edit: -1 };
    if (!this.picked) return this.stage.invalidate();
    this.picked = null;
    this.marks.clear();
    this.onPick(null);
    this.stage.invalidate();
  }

  // Trees.

  private branchAt(x: number, y: number): number {
    const { sets, view } = this.shown(), edge = pickTube(this.rayAt(x, y), view.places, sets.layer.edges, this.keep);
    return edge < 0 ? -1 : sets.layer.edgeBranch![edge]!;
  }

  /// What is picked in the table that is shown; -1: nothing.
  pickedRow(rows: Rows = this.state.rows): number { return rows === "axes" ? this.state.axis : rows === "branches" ? this.state.branch : this.state.edit; }

  private highlight(): void {
    const { state } = this, tree = this.tree!, rows = state.rows === "edits" ? "axes" : state.rows, row = this.pickedRow(rows);
    this.shown().view.highlight(tree.edgesOf(tree.branchesOf(rows, row)), tree.edgesOf(tree.pathOf(rows, row)));
  }

  /// The pointer is there; null: nowhere.
  pointAt(at: { x: number; y: number } | null): void {
    const tree = this.state.layer === "tree" ? this.tree : null;
    if (!tree) return;
    const branch = at ? this.branchAt(at.x, at.y) : -1, rows = this.state.rows === "branches" ? "branches" : "axes";
    if (branch !== this.near) {
      this.near = branch;
      const { view } = this.shown();
      view.showNear(tree.edgesOf(tree.branchesOf(rows, rows === "axes" && branch >= 0 ? tree.branchAxis[branch]! : branch)));
      this.stage.invalidate();
    }
    this.onNear(branch, at?.x ?? 0, at?.y ?? 0);
  }

  /// A row of a table of the tree, which the camera flies to; -1: none.
  pickRow(rows: Rows, row: number): void {
    const tree = this.tree!;
    if (row < 0) return this.clearPick();
    if (rows === "axes") this.set({ rows, axis: row, branch: -1 });
    else if (rows === "branches") this.set({ rows, branch: row, axis: tree.branchAxis[row]! });
    else this.set({ rows, edit: row });
    const { places } = this.shown().view, points: number[] = [];
    for (const b of tree.branchesOf(rows, row)) for (let v = tree.offsets[b]!; v < tree.offsets[b + 1]!; ++v) points.push(places[4 * v]!, places[4 * v + 1]!, places[4 * v + 2]!);
    this.fly(Float32Array.from(rows === "edits" ? this.edits!.middles[row]!.toArray() : points));
  }

  /// The repairs that are stepped through: those with marks; without any, bridges and cuts.
  editsShown(order: ArrayLike<number>): number[] {
    const { state } = this, none = !state.bridges && !state.cuts && !state.leftOut;
    return Array.from(order).filter((i) => {
      const group = groupOf(this.tree!.kind(i));
      return none ? group !== "leftOut" : state[group];
    });
  }

  /// The next or previous of the repairs in an order.
  stepEdit(direction: number, order: ArrayLike<number>): void {
    const { state } = this, list = this.editsShown(order);
    if (list.length === 0) return;
    const at = list.indexOf(state.edit), next = at < 0 ? (direction > 0 ? 0 : list.length - 1) : (at + direction + list.length) % list.length;
    this.pickRow("edits", list[next]!);
  }

  /// Moves the camera, looking as it does, so that points are in the middle and what is around them is seen.
  private fly(points: Float32Array): void {
    const { camera } = this.stage, target = camera.target.clone(), { distance } = camera, ticket = ++this.flight;
    camera.frame(points, 3, 2.2);
    const toTarget = camera.target.clone(), toDistance = Math.max(camera.distance, Math.min(distance, 0.35));
    const still = window.matchMedia?.("(prefers-reduced-motion: reduce)").matches, begin = performance.now();
    const move = () => {
      if (ticket !== this.flight) return;
      const t = still ? 1 : Math.min(1, (performance.now() - begin) / FLIGHT), eased = t * t * (3 - 2 * t);
      camera.target.lerpVectors(target, toTarget, eased);
      camera.distance = distance * (toDistance / distance) ** eased;
      this.stage.invalidate();
      if (t < 1) requestAnimationFrame(move);
      else this.onMoved();
    };
    move();
  }
  stopFlight(): void { ++this.flight; }

  // Cameras, in world coordinates.

  get camera(): Camera {
    const c = this.stage.camera;
    return { position: this.placement.toWorld(c.position), target: this.placement.toWorld(c.target), up: c.up.toArray() };
  }
  set camera(camera: Camera) {
    this.stage.camera.look(this.placement.toScene(camera.position), this.placement.toScene(camera.target), new Vector3(...camera.up));
    this.stage.invalidate();
  }

  /// Three quarters from the front; volumes stand on z, meshes on y.
  lookFrom(direction: Vector3 | null): void {
    this.stopFlight();
    const tree = this.state.layer === "tree" ? this.tree : null;
    if (tree) {
      const toEye = direction ?? new Vector3(...tree.meta.to_eye), up = new Vector3(...tree.meta.up), along = Math.abs(toEye.clone().normalize().dot(up)) > 0.99;
      this.stage.camera.orthographic = this.state.orthographic;
      this.stage.camera.look(toEye.normalize().multiplyScalar(3), new Vector3(), along ? new Vector3(...tree.meta.to_eye).multiplyScalar(-1) : up);
      return this.frame();
    }
    const upright = /\.(nrrd|nhdr|nii|nii\.gz|mha|mhd|mrc|map|vol|npy|tiff?|sof)$/i.test(this.page.meta.files.shape ?? "") ? new Vector3(0, 0, 1) : new Vector3(0, 1, 0);
    const toEye = direction ?? (upright.z ? new Vector3(0.62, -0.72, 0.32) : new Vector3(0.55, 0.3, 0.78));
    const up = Math.abs(toEye.clone().normalize().dot(upright)) > 0.99 ? (upright.z ? new Vector3(0, 1, 0) : new Vector3(0, 0, -1)) : upright;
    this.stage.camera.orthographic = this.state.orthographic;
    this.stage.camera.look(toEye.clone().normalize().multiplyScalar(3), new Vector3(), up);
    this.frame();
  }

  frame(): void {
    const { view } = this.shown();
    const sample = this.state.shape && (this.glass ?? this.figure)?.sample;
    if (sample) this.stage.camera.frame(sample, 3 * Math.ceil(sample.length / 60000), 1.04);
    else if (view.layer.tree) this.stage.camera.frame(outsides(view.places), 3, 1.04);
    else this.stage.camera.frame(view.places, 4 * Math.ceil(view.places.length / 80000), 1.04);
    this.stage.invalidate();
    this.onMoved();
  }
}

/// Places around balls (places with a radius, of many some): where what is drawn of them ends.
function outsides(places: Float32Array): Float32Array {
  const out: number[] = [], step = 4 * Math.ceil(places.length / 80000);
  for (let i = 0; i + 3 < places.length; i += step) for (let k = 0; k < 3; ++k) for (const sign of [-1, 1]) out.push(...[0, 1, 2].map((j) => places[i + j]! + (j === k ? sign * places[i + 3]! : 0)));
  return Float32Array.from(out);
}
