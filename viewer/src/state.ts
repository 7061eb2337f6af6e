// SPDX-License-Identifier: Apache-2.0
// Everything a view consists of, and its form in the address (FORMAT.md, "State in the address").
import type { LayerName, Meta, Page } from "./data";
import { decimalOf, exact, floor32, parseLength } from "./format";
import { measuresOf, UNIFORM } from "./measures";

export interface Camera {
  position: [number, number, number];
  target: [number, number, number];
  up: [number, number, number];
}

export type SheetSlider = "threshold" | "theta2";

/// The parameter that prunes the sheets of what is shown; a complex without levels has none.
export function sheetSlider(state: State): SheetSlider | null {
  return state.layer === "core" ? "threshold" : state.layer === "skeleton" ? "theta2" : null;
}

export type Axis = "x" | "y" | "z" | "view";

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
  points: boolean;
  curvesByMeasure: boolean;
  curveWidth: number; ///< pixels
  shape: boolean;
  shapeOpacity: number;
  balls: boolean;
  clip: boolean;
  clipAxis: Axis;
  clipAt: number; ///< 0 .. 1 through the box
  clipFlip: boolean;
  burn: boolean;
  time: number; ///< world units; what burns before is gone
  burnHides: boolean;
  orthographic: boolean;
  dark: boolean;
  ui: boolean;
}

export function defaultLayer(page: Page): LayerName {
  return page.layers.has("skeleton") ? "skeleton" : page.layers.has("core") ? "core" : "still";
}

export function defaultColor(page: Page, name: LayerName): string {
  const names = measuresOf(page.layers.get(name)!);
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
  const pure = layer === "skeleton" && meta.theta2 === Infinity && page.layers.get(layer)!.measures.has("radius");
  const measure = startingMeasure(meta);
  const state: State = {
    layer,
    measure,
    threshold: startingThreshold(meta, measure),
    theta2: Math.max(meta.theta2 ?? 0, meta.floor.theta2),
    theta1: Math.max(meta.theta1 ?? 0, meta.floor.theta1),
    color: pure ? "radius" : defaultColor(page, layer),
    map: "viridis",
    rangeLow: NaN,
    rangeHigh: NaN,
    sheets: true,
    curves: true,
    seams: true,
    boundary: true,
    points: true,
    curvesByMeasure: pure,
    curveWidth: curvesAtStart(page) > 12 * meta.side ? 3 : 5,
    shape: page.shape.triangles !== null,
    shapeOpacity: 0.5,
    balls: false,
    clip: false,
    clipAxis: "x",
    clipAt: 0.5,
    clipFlip: false,
    burn: false,
    time: 0,
    burnHides: false,
    orthographic: false,
    dark,
    ui: true,
  };
  return sanitize(state, page);
}

/// About the length of the curves the page starts with: many are drawn thinner.
function curvesAtStart(page: Page): number {
  const layer = page.layers.get("skeleton");
  let sum = 0;
  if (!layer?.curveEdges || !layer.curveThickness) return sum;
  const { points, edges } = layer;
  for (let i = 0; i < layer.curveEdges.length; ++i) {
    if (layer.curveThickness[i]! < (page.meta.theta1 ?? 0)) continue;
    const a = 3 * edges[2 * layer.curveEdges[i]!]!, b = 3 * edges[2 * layer.curveEdges[i]! + 1]!;
    sum += Math.hypot(points[a]! - points[b]!, points[a + 1]! - points[b + 1]!, points[a + 2]! - points[b + 2]!);
  }
  return sum;
}

/// What makes no sense (a layer or array that is not there, a length below the floor) is put right.
export function sanitize(state: State, page: Page): State {
  const s = { ...state };
  if (!page.layers.has(s.layer)) s.layer = defaultLayer(page);
  if (s.color !== UNIFORM && !page.layers.get(s.layer)!.measures.has(s.color)) s.color = defaultColor(page, s.layer);
  const length = (x: number, floor: number) => floor32(Number.isNaN(x) ? floor : Math.max(x, floor));
  if (!page.meta.measures.some((m) => m.name === s.measure)) {
    s.measure = startingMeasure(page.meta);
    s.threshold = NaN;
  }
  if (Number.isNaN(s.threshold)) s.threshold = startingThreshold(page.meta, s.measure);
  s.threshold = length(s.threshold, page.meta.measures.find((m) => m.name === s.measure)?.floor ?? 0);
  s.theta2 = length(s.theta2, page.meta.floor.theta2);
  s.theta1 = length(s.theta1, page.meta.floor.theta1);
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
    const belongs = key === "threshold" && state.measure !== base.measure; // to the measure that is written
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
