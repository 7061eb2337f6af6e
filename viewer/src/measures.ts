// SPDX-License-Identifier: Apache-2.0
// What the arrays of the page are called and what they mean.
import type { Layer, Meta } from "./data";
import { short, withUnit } from "./format";
import { unitText, type Column } from "./table";
import type { TableName } from "./tree";

/// `pruning`: what a pruning by it does. `infinite`: what infinite values mean.
interface Measure { label: string; help: string; unit?: string; pruning?: string; infinite?: string }

export const MEASURES: Record<string, Measure> = {
  radius: { label: "radius", help: "Distance to the boundary of the shape." },
  thickness: { label: "thickness", help: "Diameter of the largest ball inside the shape that contains the place." },
  detail: { label: "detail", help: "The largest detail at which the pruning keeps a place.", pruning: "Drops what sticks out less than this", infinite: "infinite: always kept" },
  cap_height: { label: "cap height", help: "What the shape loses where the axis ends here.", pruning: "Drops cells where the shape loses less than this if the axis ends there" },
  lambda: { label: "λ", help: "Half the largest distance of nearest boundary points around.", pruning: "Drops what is thinner than this radius" },
  mgf: { label: "MGF", help: "Medial geodesic function: the length of the shortest way on the surface, of images along the outline, between the nearest boundary points.", infinite: "infinite: between two outlines" },
  circumradius: { label: "circumradius", help: "Radius of the ball, of a polygon the smallest of its corners.", pruning: "Drops what is thinner than this" },
  chord_residual: { label: "chord residual", help: "What the shortest way on the surface between the nearest boundary points is longer than their distance.", infinite: "infinite: between two outlines" },
  core_erosion_thickness: { label: "erosion thickness of the core", help: "Burn time − radius when the whole core is burned, of a polygon the smallest of its corners." },
  relative_erosion_thickness: { label: "relative erosion thickness", help: "Erosion thickness of the core as a share of the burn time.", unit: "" },
  scale_axis: { label: "scale axis", help: "The factor by which all balls grow until a larger one swallows the ball.", unit: "", pruning: "Drops what a larger ball has swallowed when all have grown by this factor", infinite: "infinite: never swallowed" },
  burn_time: { label: "burn time", help: "When the fire that starts at the rim of the sheets comes by." },
  erosion_thickness: { label: "erosion thickness", help: "Burn time − radius: how much longer a place lasts than its radius." },
  object_angle: { label: "object angle", help: "Angle between the nearest boundary points, seen from here.", unit: "°" },
  angle_to_down: { label: "angle to down", help: "Angle between the course and the direction down.", unit: "°" },
  strahler: { label: "Strahler number", help: "Horton-Strahler number of the branch.", unit: "" },
  order: { label: "order", help: "Centrifugal order: forks between the root node and the branch.", unit: "" },
  curve_burn_time: { label: "curve burn time", help: "When the fire along the curves comes by." },
  curve_erosion_thickness: { label: "curve erosion thickness", help: "Curve burn time − burn time: how much longer a curve lasts than its sheets." },
};

/// Of a measure: lengths but for what says otherwise, as the columns of tables do.
export function unitOf(name: string, length: string, layer?: Layer): string {
  const [table, column] = name.split("/");
  if (column !== undefined) return unitText((table === "sheets" ? sheetColumn(layer, name) : layer?.tree?.column(table as TableName, column))?.unit ?? "");
  return MEASURES[name]?.unit ?? length;
}
/// The column of the table of sheets that a colour is by: `sheets/NAME`.
export const sheetColumn = (layer: Layer | undefined, name: string): Column | undefined => (name.startsWith("sheets/") ? layer?.sheets?.columns.find((c) => c.name === name.slice(7)) : undefined);
/// What a layer is coloured by: a value per vertex, or per sheet.
export const valuesOf = (layer: Layer, name: string): Float32Array | undefined => layer.measures.get(name) ?? sheetColumn(layer, name)?.values;

export const isLength = (name: string): boolean => MEASURES[name]?.unit === undefined;

/// What pruning by a measure does, for help.
export const pruningBy = (name: string): string => MEASURES[name]?.pruning ?? `Drops what has a smaller ${labelOf(name)}`;

/// What the shape consists of.
export const elementOf = ({ plane }: Meta): string => (plane ? "pixel" : "voxel");

/// The pruning of the axis that was burned: "detail = 0.36 mm (0.87 voxels)".
export function pruningText(meta: Meta): string {
  const { pruning, unit, voxel } = meta;
  if (!pruning) return "";
  const { measure, threshold } = pruning;
  const voxels = voxel && isLength(measure) && Number.isFinite(threshold) ? ` (${short(threshold / voxel)} ${elementOf(meta)}s)` : "";
  return `${labelOf(measure)} = ${withUnit(short(threshold), unitOf(measure, unit))}${voxels}`;
}

export const infinityOf = (name: string): string => MEASURES[name]?.infinite ?? "infinite: no fire comes";

export const UNIFORM = "none";
/// Numbers of parts, not measures: each has a colour of its own.
export const isCategory = (layer: Layer, name: string): boolean => layer.parts.has(name) || (name === "sheet" && layer.sheet !== null && layer.faceCount > 0) || (name === "branch" && layer.branches !== null);
const NUMBERS = ["sheet", "id"]; ///< columns that number things
const CATEGORIES = ["sheet", "branch"];

export function labelOf(name: string): string {
  if (name === UNIFORM) return "one colour";
  const [table, column] = name.split("/");
  if (column !== undefined) return `${labelOf(column)} of the ${table === "axes" ? "axis" : table === "sheets" ? "sheet" : "branch"}`;
  return MEASURES[name]?.label ?? name.replaceAll("_", " ");
}

/// Smallest, largest and central values of an array: of many values a sample, for the ranges of colours.
export interface Range { low: number; high: number; centralHigh: number; centralLow: number; finite: number; infinite: number; missing: number }

/// `included` (1 per vertex that counts) may be missing.
export function rangeOf(values: Float32Array, included: Uint8Array | null = null): Range {
  let low = Infinity, high = -Infinity, finite = 0, infinite = 0, count = 0;
  for (let i = 0; i < values.length; ++i) {
    if (included && !included[i]) continue;
    const x = values[i]!;
    ++count;
    if (Number.isFinite(x)) {
      ++finite;
      if (x < low) low = x;
      if (x > high) high = x;
    } else if (!Number.isNaN(x)) ++infinite;
  }
  if (finite === 0) return { low: 0, high: 0, centralLow: 0, centralHigh: 0, finite, infinite, missing: count - infinite };
  const stride = Math.max(1, Math.floor(count / 50000));
  const sample: number[] = [];
  for (let i = 0, k = 0; i < values.length; ++i) {
    if ((included && !included[i]) || !Number.isFinite(values[i]!)) continue;
    if (k++ % stride === 0) sample.push(values[i]!);
  }
  if (sample.length === 0) sample.push(low, high);
  const sorted = Float32Array.from(sample).sort();
  const at = (q: number) => sorted[Math.min(sorted.length - 1, Math.floor(q * sorted.length))]!;
  return { low, high, centralLow: at(0.005), centralHigh: at(0.995), finite, infinite, missing: count - finite - infinite };
}

/// The measures a layer can be coloured by, in a fixed order, unknown ones last.
export function measuresOf(layer: Layer): string[] {
  if (layer.tree) return [...layer.parts.keys(), ...layer.measures.keys()];
  const known = Object.keys(MEASURES).filter((name) => layer.measures.has(name));
  const ofSheets = (layer.sheets?.columns ?? []).filter((c) => !c.words && !NUMBERS.includes(c.name)).map((c) => `sheets/${c.name}`);
  return [...known, ...[...layer.measures.keys()].filter((name) => !known.includes(name)), ...CATEGORIES.filter((name) => isCategory(layer, name)), ...ofSheets];
}
