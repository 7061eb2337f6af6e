// SPDX-License-Identifier: Apache-2.0
// Everything a view consists of, and its form in the address (FORMAT.md, "State in the address").
import type { Layer, LayerKey, LayerName, Meta, Page } from "./data";
import { decimalOf, exact, floor32, parseLength } from "./format";
import { measuresOf, UNIFORM } from "./measures";
import { ROWS, type Rows } from "./tree";

export interface Camera {
  position: [number, number, number];
  target: [number, number, number];
  up: [number, number, number];
}

export type SheetSlider = "threshold" | "theta2";
export type SliderId = SheetSlider | "theta1";

/// The parameters that prune what is shown, that of the sheets first; a complex without levels has none.
export function slidersOf({ meta }: Page, state: State): SliderId[] {
  if (state.layer === "still" || state.layer === "tree" || state.layer === "simple") return [];
  return state.layer === "core" ? ["threshold"] : meta.plane ? ["theta1"] : ["theta2", "theta1"];
}

/// The thetas of the skeleton that was asked for.
export function askedThetas({ theta2, theta1 }: Meta): [number, number] { return [floor32(theta2 ?? 0), floor32(theta1 ?? 0)]; }

export function isAsked(page: Page, state: State): boolean {
  const [theta2, theta1] = askedThetas(page.meta);
  return state.theta2 === theta2 && state.theta1 === theta1;
}

export const hasLayer = (page: Page, name: LayerName): boolean => page.layers.has(name) || (name === "skeleton" && page.layers.has("family"));

/// Which layer of the page shows a state: the skeleton that was asked for where the sliders stand there, else its family.
export function keyOf(page: Page, state: State): LayerKey {
  const { layers } = page;
  if (state.layer !== "skeleton" || !layers.has("family")) return state.layer;
  return layers.has("skeleton") && isAsked(page, state) ? "skeleton" : "family";
}
export function layerOf(page: Page, state: State): Layer {
  const layer = page.layers.get(keyOf(page, state))!;
  return layer.collapses?.at(layer.collapses.clamp(state.vertices)) ?? layer;
}

export type Axis = "x" | "y" | "z" | "view";

/// What the table of a skeleton is of.
export const LISTS = ["branches", "sheets"] as const;
export type List = (typeof LISTS)[number];
const VERTICES = 200; ///< of a medial mesh that is shown at first

export interface State {
  layer: LayerName;
  measure: string; ///< by which the layer `core` is pruned
  threshold: number; ///< of that measure
  theta2: number;
  theta1: number;
  color: string;
  map: string;
  /// Colour range in world units; NaN: chosen from the values.
  rangeLow: number;
  rangeHigh: number;
  sheets: boolean;
  curves: boolean;
  seams: boolean;
  boundary: boolean;
  branch: number; ///< that is picked; -1: none
  sheet: number; ///< that is picked; -1: none
  list: List; ///< of what the table of a skeleton is
  vertices: number; ///< of the layer `simple`
  axis: number; ///< of a tree, that is picked; -1: none
  edit: number; ///< of the repairs of a tree; -1: none
  rows: Rows; ///< of what the table of a tree is
  tubes: boolean; ///< branches of a tree as thick as they are
  bridges: boolean; ///< marks of these repairs
  cuts: boolean;
  leftOut: boolean;
  table: boolean; ///< of the branches
  points: boolean;
  curvesByMeasure: boolean;
  curveWidth: number; ///< pixels
  shape: boolean;
  shapeOpacity: number;
  surface: string; ///< by what the shape is coloured
  balls: boolean;
  clip: boolean;
  clipAxis: Axis;
  clipAt: number; ///< 0 .. 1 through the box
  clipFlip: boolean;
  burn: boolean;
  time: number; ///< world units; what burns before is gone
  burnHides: boolean;
  orthographic: boolean;
  axes: boolean;
  caption: boolean;
  dark: boolean;
  ui: boolean;
}

export function defaultLayer(page: Page): LayerName {
  return hasLayer(page, "tree") ? "tree" : hasLayer(page, "skeleton") ? "skeleton" : page.layers.has("core") ? "core" : page.layers.has("simple") ? "simple" : "still";
}

export function defaultColor(layer: Layer): string {
  const names = measuresOf(layer);
  if (layer.tree) return "level";
  for (const wanted of ["erosion_thickness", "radius", "lambda"]) if (names.includes(wanted)) return wanted;
  return names[0] ?? UNIFORM;
}

/// The threshold of a measure that a page starts with: of that by which the axis was pruned when it was burned, else
/// all that there is.
export function startingThreshold(meta: Meta, measure: string): number {
  const floor = meta.measures.find((m) => m.name === measure)?.floor ?? 0;
  return meta.pruning?.measure === measure ? Math.max(meta.pruning.threshold, floor) : floor;
}

function startingMeasure({ measures, pruning }: Meta): string {
  return (measures.find((m) => m.name === pruning?.measure) ?? measures[0])?.name ?? "";
}

export function defaults(page: Page, dark: boolean): State {
  const { meta } = page;
  const layer = defaultLayer(page);
  // Without sheets the curves carry the colours.
  const first = page.layers.get(layer) ?? page.layers.get("family")!;
  const lone = page.layers.get("skeleton")?.faceCount === 0;
  const pure = layer === "skeleton" && (meta.plane || meta.theta2 === Infinity || lone) && first.measures.has("radius");
  const [theta2, theta1] = askedThetas(meta);
  const measure = startingMeasure(meta);
  const [thick, thin] = meta.plane ? [3, 2] : [5, 3];
  const state: State = {
    layer,
    measure,
    threshold: startingThreshold(meta, measure),
    theta2,
    theta1,
    color: pure ? "radius" : defaultColor(first),
    map: "viridis",
    rangeLow: NaN,
    rangeHigh: NaN,
    sheets: true,
    curves: true,
    seams: true,
    boundary: true,
    branch: -1,
    sheet: -1,
    list: "branches",
    vertices: VERTICES,
    axis: -1,
    edit: -1,
    rows: "axes",
    tubes: true,
    bridges: first.tree?.marksAtFirst("bridges") ?? true,
    cuts: first.tree?.marksAtFirst("cuts") ?? true,
    leftOut: false,
    table: false,
    points: true,
    curvesByMeasure: pure || meta.plane || layer === "tree",
    curveWidth: curvesAtStart(page) > 12 * meta.side ? thin : thick,
    shape: page.shape.triangles !== null && layer !== "tree", // its tubes are about where the surface is
    shapeOpacity: 0.5,
    surface: UNIFORM,
    balls: false,
    clip: false,
    clipAxis: "x",
    clipAt: 0.5,
    clipFlip: false,
    burn: false,
    time: 0,
    burnHides: false,
    orthographic: meta.plane,
    axes: false,
    caption: true,
    dark,
    ui: true,
  };
  return sanitize(state, page);
}

/// About the length of the curves the page starts with: many are drawn thinner.
function curvesAtStart(page: Page): number {
  const lengths = page.layers.get("skeleton")?.branches?.measures.length;
  return lengths ? lengths.reduce((sum, x) => sum + x, 0) : 0;
}

/// What makes no sense (a layer or array that is not there, a length below the floor) is put right.
export function sanitize(state: State, page: Page): State {
  const s = { ...state };
  if (!hasLayer(page, s.layer)) s.layer = defaultLayer(page);
  const length = (x: number, floor: number) => floor32(Number.isNaN(x) ? floor : Math.max(x, floor));
  if (!page.meta.measures.some((m) => m.name === s.measure)) {
    s.measure = startingMeasure(page.meta);
    s.threshold = NaN;
  }
  if (Number.isNaN(s.threshold)) s.threshold = startingThreshold(page.meta, s.measure);
  s.threshold = length(s.threshold, page.meta.measures.find((m) => m.name === s.measure)?.floor ?? 0);
  s.theta2 = length(s.theta2, 0);
  s.theta1 = length(s.theta1, 0);
  if (page.layers.has("skeleton") && !page.layers.has("family")) [s.theta2, s.theta1] = askedThetas(page.meta);
  else if (!page.layers.has("skeleton") || !isAsked(page, s)) {
    s.theta2 = length(s.theta2, page.meta.floor.theta2);
    s.theta1 = length(s.theta1, page.meta.floor.theta1);
  }
  s.vertices = page.layers.get("simple")?.collapses?.clamp(s.vertices) ?? VERTICES;
  const layer = layerOf(page, s);
  const known = s.color === UNIFORM || measuresOf(page.layers.get(s.layer) ?? layer).includes(s.color);
  if (!known) s.color = defaultColor(layer);
  s.branch = Number.isInteger(s.branch) && s.branch >= 0 && s.branch < (layer.tree?.branchCount ?? layer.branches?.count ?? 0) ? s.branch : -1;
  s.sheet = layer.sheet && Number.isInteger(s.sheet) && s.sheet >= 0 && layer.sheet.includes(s.sheet) ? s.sheet : -1;
  if (!LISTS.includes(s.list)) s.list = "branches";
  const asked = page.layers.get("skeleton");
  if (!asked?.sheets) s.list = "branches";
  else if (!asked.branches) s.list = "sheets";
  if (s.surface !== UNIFORM && !page.shape.measures.has(s.surface)) s.surface = UNIFORM;
  const row = (x: number, count: number | undefined) => (Number.isInteger(x) && x >= 0 && x < (count ?? 0) ? x : -1);
  s.axis = row(s.axis, layer.tree?.axisCount);
  s.edit = row(s.edit, layer.tree?.editCount);
  if (!ROWS.includes(s.rows)) s.rows = "axes";
  if (page.meta.plane) {
    s.orthographic = true;
    s.clip = false;
  }
  s.clipAt = Math.min(1, Math.max(0, s.clipAt || 0));
  s.shapeOpacity = Math.min(1, Math.max(0, s.shapeOpacity));
  s.shape &&= page.shape.triangles !== null;
  return s;
}

// Names in the address are those of FORMAT.md where it names them; the others are those of the state.
const SKIPPED = new Set<keyof State>(["ui", "dark"]);

export function toHash(state: State, base: State, camera: Camera | null): string {
  const parts: string[] = [];
  for (const key of Object.keys(base) as (keyof State)[]) {
    const value = state[key];
    const belongs = (key === "threshold" && state.measure !== base.measure) || (key === "shapeOpacity" && state.surface !== base.surface); // to what is written
    if (SKIPPED.has(key) || (Object.is(value, base[key]) && !belongs)) continue;
    const isLength = key === "threshold" || key === "theta2" || key === "theta1";
    parts.push(`${key}=${isLength ? decimalOf(value as number, true) : typeof value === "boolean" ? Number(value) : typeof value === "number" ? exact(value) : encodeURIComponent(value)}`);
  }
  if (state.dark !== base.dark) parts.push(`dark=${Number(state.dark)}`);
  if (!state.ui) parts.push("ui=0");
  if (camera) parts.push(`camera=${[...camera.position, ...camera.target, ...camera.up].map((x) => Number(x.toPrecision(6))).join(",")}`);
  return parts.join("&");
}

export function fromHash(hash: string, base: State): { state: State; camera: Camera | null } {
  const state: State = { ...base };
  const fields = state as unknown as Record<string, string | number | boolean>;
  let camera: Camera | null = null;
  const values = new URLSearchParams(hash.replace(/^#/, "").replaceAll("+", "%2B"));
  // Addresses of older pages have a parameter of its own for the pruning by lambda.
  const lambda = values.get("lambda");
  if (lambda !== null && (values.get("measure") ?? "lambda") === "lambda") {
    values.set("measure", "lambda");
    values.set("threshold", lambda);
  }
  if (values.has("surface")) state.shapeOpacity = 1; // colours want to be seen
  if ((values.get("measure") ?? base.measure) !== base.measure) state.threshold = NaN; // that of base is of another measure
  for (const [key, value] of values) {
    if (key === "camera") {
      const n = value.split(",").map(Number);
      if (n.length === 9 && n.every(Number.isFinite))
        camera = { position: [n[0]!, n[1]!, n[2]!], target: [n[3]!, n[4]!, n[5]!], up: [n[6]!, n[7]!, n[8]!] };
      continue;
    }
    const old = fields[key];
    if (typeof old === "boolean") fields[key] = value === "1" || value === "true";
    else if (typeof old === "number") {
      const length = parseLength(value);
      if (!Number.isNaN(length)) fields[key] = length;
    } else if (typeof old === "string") fields[key] = value;
  }
  return { state, camera };
}
