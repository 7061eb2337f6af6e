// SPDX-License-Identifier: Apache-2.0
// The command line that writes what the page shows.
import type { Meta, Page } from "./data";
import { decimalOf, floor32 } from "./format";
import { isAsked, layerOf, type State } from "./state";

const quoted = (file: string) => (/^[\w.,:+@%/-]+$/.test(file) ? file : `'${file.replaceAll("'", "'\\''")}'`);
const length = (x: number, levels: Float32Array | null) => (Number.isFinite(x) ? (x === 0 ? "0" : `${decimalOf(x, levels?.includes(x) ?? false)}abs`) : "inf");

/// What a threshold of the core stands for: of the number it was pruned with nothing is in the page that is below.
function exactThreshold({ pruning }: Meta, { measure, threshold }: State): string | null {
  return pruning?.measure === measure && threshold > 0 && floor32(pruning.threshold) === threshold && Number.isFinite(threshold) ? `${pruning.threshold}abs` : null;
}

/// What the shape was read with (resolution, threshold ...) is in the command of the page.
function shapeOptions({ command }: Meta): string[] {
  const words = command.match(/'[^']*'|"[^"]*"|\S+/g) ?? [], kept: string[] = [];
  for (let i = 0; i < words.length; ++i) {
    const [name, value] = words[i]!.split(/=(.*)/s) as [string, string | undefined];
    if (SHAPE_OPTIONS.includes(name)) kept.push(value === undefined ? `${name} ${words[++i] ?? ""}` : words[i]!);
    else if (SHAPE_FLAGS.includes(name)) kept.push(name);
  }
  return kept;
}

const isMesh = (file: string) => /\.(ply|obj|off|stl|vtp)$/i.test(file);

export function commandOf(page: Page, state: State): string {
  const { meta } = page, layer = layerOf(page, state);
  const family = page.layers.get("family");
  const asked = page.layers.has("skeleton") && isAsked(page, state);
  const theta1 = asked && meta.theta1_radii > 0 ? `${meta.theta1_radii}r` : length(state.theta1, family?.curveThickness ?? null);
  if (state.shape && state.surface === "thickness" && state.shapeOpacity > 0.98 && meta.files.shape)
    return ["quench thickness", quoted(meta.files.shape), ...shapeOptions(meta), isMesh(meta.files.shape) ? "--surface thickness.ply" : "-o thickness.nrrd"].join(" ");
  if (state.layer === "simple") return `quench simplify ${quoted(meta.files.core ?? "core.vtp")} --vertices ${state.vertices}${meta.files.shape ? ` --shape ${quoted(meta.files.shape)}` : ""} -o mesh.vtp`;
  if (state.layer === "skeleton" && meta.files.core === undefined && meta.command.includes(" run ")) return meta.command; // of many shapes there is no file of one axis
  if (state.layer === "skeleton")
    return `quench skeleton ${quoted(meta.files.core ?? "core.vtp")}${meta.plane ? "" : ` --theta2 ${length(state.theta2, family?.faceLevel ?? null)}`} --theta1 ${theta1}${asked ? "" : " --tips pruned"} -o skeleton.vtp`;
  if (state.layer === "core") {
    const option = PRUNING_OPTIONS[state.measure];
    if (option === undefined) return ""; // no command prunes by another measure
    const other = layer.otherLevels.get(state.measure);
    const levels = meta.plane ? (other?.edge ?? layer.edgeLevel) : (other?.face ?? layer.faceLevel);
    const threshold = exactThreshold(meta, state) ?? length(state.threshold, levels);
    return ["quench core", quoted(meta.files.shape ?? "SHAPE"), ...shapeOptions(meta), `${option} ${threshold}`, "-o core.vtp"].join(" ");
  }
  return meta.command;
}

const PRUNING_OPTIONS: Record<string, string> = { detail: "--detail", lambda: "--lambda" };
const SHAPE_OPTIONS = ["--resolution", "--fill", "--threshold", "--label", "--spacing", "--min-component", "--subdivide", "--lambda-rule", "--channel", "--dimension", "--pixel"];
const SHAPE_FLAGS = ["--invert", "--largest-component", "--fill-cavities"];
