// SPDX-License-Identifier: Apache-2.0
// The command line that writes what the page shows.
import type { Page } from "./data";
import { decimalOf } from "./format";
import { LAMBDA, type State } from "./state";

const quoted = (file: string) => (/^[\w.,:+@%/-]+$/.test(file) ? file : `'${file.replaceAll("'", "'\\''")}'`);
const length = (x: number, levels: Float32Array | null) => (Number.isFinite(x) ? (x === 0 ? "0" : `${decimalOf(x, levels?.includes(x) ?? false)}abs`) : "inf");

export function commandOf(page: Page, state: State): string {
  const { meta } = page, layer = page.layers.get(state.layer)!;
  if (state.layer === "skeleton")
    return `quench skeleton ${quoted(meta.files.core ?? "core.vtp")} --theta2 ${length(state.theta2, layer.faceLevel)} --theta1 ${length(state.theta1, layer.curveThickness)} -o skeleton.vtp`;
  if (state.layer === "core" && state.measure !== LAMBDA) return ""; // no command prunes by another measure
  if (state.layer === "core") {
    // What the shape was read with (resolution, threshold ...) is in the command of the page.
    const words = meta.command.match(/'[^']*'|"[^"]*"|\S+/g) ?? [];
    const kept: string[] = [];
    for (let i = 0; i < words.length; ++i) {
      const [name, value] = words[i]!.split(/=(.*)/s) as [string, string | undefined];
      if (SHAPE_OPTIONS.includes(name)) kept.push(value === undefined ? `${name} ${words[++i] ?? ""}` : words[i]!);
      else if (SHAPE_FLAGS.includes(name)) kept.push(name);
    }
    return ["quench core", quoted(meta.files.shape ?? "SHAPE"), ...kept, `--lambda ${length(state.lambda, layer.faceLevel)}`, "-o core.vtp"].join(" ");
  }
  return meta.command;
}

const SHAPE_OPTIONS = ["--resolution", "--fill", "--threshold", "--label", "--spacing", "--min-component", "--subdivide", "--lambda-rule"];
const SHAPE_FLAGS = ["--invert", "--largest-component", "--fill-cavities"];
