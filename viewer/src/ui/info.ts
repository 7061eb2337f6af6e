// SPDX-License-Identifier: Apache-2.0
// What am I looking at: title, figures of what is visible, what the result is, and the command that writes it.
import type { Page } from "../data";
import { counted, short, withUnit } from "../format";
import type { Numbers, Picked } from "../app";
import { elementOf, labelOf, pruningText, unitOf } from "../measures";
import { isAsked, LISTS, type State } from "../state";
import { copyText, listText, type BranchTable } from "./branches";
import type { CountSlider } from "./count_slider";
import type { TreeInfo } from "./tree_info";
import { el, fill, rows } from "./dom";

const NAMES = { tree: "Tree", skeleton: "Skeleton", core: "Medial axis", still: "Other result", simple: "Medial mesh" };

export class Info {
  readonly element = el("section", "info");
  readonly command = el("div", "command");
  private readonly what = el("p", "what");
  private readonly figures = el("div", "figures");
  private readonly share = el("p", "share");
  private readonly picked = el("div", "picked");
  private readonly commandText = el("code");
  onClearPick: () => void = () => {};

  private readonly sheets: number; ///< of the skeleton that was asked for
  private readonly branch = el("div", "chosen-branch");
  private readonly sheet = el("div", "chosen-branch chosen-sheet");
  meshes: CountSlider | null = null; ///< knows their errors
  private readonly toTable = el("button", "plain to-table");
  onTable: () => void = () => {};

  constructor(private readonly page: Page, private readonly table: BranchTable, private readonly tree: TreeInfo | null, help: () => void) {
    const { meta } = page;
    this.sheets = (page.layers.get("skeleton")?.sheet ?? new Uint32Array(0)).reduce((most, s) => Math.max(most, s + 1), 0);
    const about = el("details", "about", el("summary", "", "About this result"));
    const facts: [string, string][] = [];
    if (meta.topology) facts.push(["shape", topology(meta.topology.betti, meta.topology.euler, meta.plane)]);
    facts.push(["longest side", withUnit(short(meta.side, 4), meta.unit)]);
    if (meta.voxel) facts.push([elementOf(meta), withUnit(short(meta.voxel, 4), meta.unit)]);
    if (meta.pruning) facts.push(["burned at", pruningText(meta)]);
    if (meta.burning?.omega !== undefined) facts.push(["ω", withUnit(short(meta.burning.omega, 4), meta.unit)]);
    if (meta.burning?.propagation) facts.push(["propagation", meta.burning.propagation]);
    facts.push(["written by", meta.program]);
    about.append(rows(facts));
    if (meta.command) about.append(el("code", "made", meta.command));
    const question = el("button", "plain round", "?");
    question.title = "Keys and mouse (?)";
    question.addEventListener("click", help);
    const note = meta.note ? el("p", "note", meta.note) : null;
    about.append(...meta.notes.map((text) => el("p", "note", `${text}.`.replace(/\.\.$/, "."))));
    this.element.append(el("header", "", el("h1", "", meta.title), question), this.what, this.figures, ...(tree ? [tree.element] : []), this.toTable, this.share, ...(note ? [note] : []), about, this.branch, this.sheet, this.picked);
    this.toTable.addEventListener("click", () => this.onTable());
    const copy = el("button", "plain", "Copy");
    copy.addEventListener("click", () => void copyText(this.commandText.textContent ?? "", copy));
    this.command.append(this.commandText, copy);
    this.command.title = "The command that writes what is visible to a file";
  }

  show(state: State, numbers: Numbers, command: string): void {
    const { meta } = this.page, unit = meta.unit;
    const asked = state.layer === "skeleton" && isAsked(this.page, state), lists = asked ? LISTS.filter((list) => this.table.count(list) > 0) : [];
    this.tree?.show();
    if (this.tree && state.layer === "tree") {
      this.toTable.hidden = true; // it has its own
      fill(this.what, el("b", "", NAMES.tree));
      fill(this.figures);
      this.commandText.textContent = command;
      this.command.hidden = command === "";
      return;
    }
    this.toTable.hidden = lists.length === 0;
    this.toTable.textContent = `${state.table ? "Hide the table" : "Table"} of ${lists.map((list) => listText(list, this.table.count(list))).join(" and ")}`;
    const length = (x: number) => withUnit(short(x), unit);
    const sentence: string[] = [];
    if (state.layer === "skeleton") {
      const two = Number.isFinite(state.theta2) ? `sheets of erosion thickness ≥ ${length(state.theta2)}` : "no sheets but those that enclose a cavity";
      const one = Number.isFinite(state.theta1) ? `curves of ${meta.plane ? "" : "curve "}erosion thickness ≥ ${length(state.theta1)}` : "curves only where topology needs them";
      const radii = isAsked(this.page, state) && this.page.layers.has("skeleton") ? meta.theta1_radii : 0;
      sentence.push(`${meta.plane ? "" : `${two}; `}${one}${radii > 0 ? ` that stick out by ${short(radii)} radii` : ""}${isAsked(this.page, state) && this.page.layers.has("skeleton") ? " (as asked)" : ""}`);
    } else if (state.layer === "core") {
      sentence.push(`pruned at ${labelOf(state.measure)} = ${withUnit(short(state.threshold), unitOf(state.measure, unit))}`);
      const burned = meta.pruning, isBurning = state.color === "burn_time" || state.color === "erosion_thickness";
      if (burned && isBurning && (state.measure !== burned.measure || Math.abs(state.threshold - burned.threshold) > 1e-6 * meta.side))
        sentence.push(`burn times belong to ${pruningText(meta)}`);
    }
    if (state.layer === "simple") {
      sentence.push(`${counted(state.vertices)} vertices with triangles and edges between them`);
      const error = this.meshes?.errorText(state.vertices) ?? "";
      if (error) sentence.push(`the boundary is off its envelope by ${error}`);
    }
    fill(this.what, el("b", "", NAMES[state.layer]), sentence.length ? `: ${sentence.join("; ")}.` : "");
    const entries: [string, string][] = [];
    const sheets = state.layer === "skeleton" && isAsked(this.page, state) ? this.sheets : 0;
    if (state.layer === "simple") entries.push(["cells", `${counted(numbers.faces)} triangles, ${counted(numbers.curveEdges)} edges beside`]);
    else if (numbers.faces > 0) entries.push(["sheets", `${sheets > 0 ? `${counted(sheets)}, ` : ""}${counted(numbers.faces)} faces, area ${withUnit(short(numbers.area), unit && `${unit}²`)}`]);
    if (state.layer !== "simple" && numbers.curveEdges > 0) entries.push(["curves", `length ${length(numbers.curveLength)}, ${numbers.freeEnds === 0 ? "no" : counted(numbers.freeEnds)} free ${numbers.freeEnds === 1 ? "end" : "ends"}`]);
    if (numbers.isolated > 0) entries.push(["points", counted(numbers.isolated)]);
    entries.push([meta.plane ? "χ = V − E" : "χ = V − E + F", `${numbers.vertices - numbers.edges + numbers.faces}`.replace("-", "−")]);
    fill(this.figures, rows(entries));
    this.commandText.textContent = command;
    this.command.hidden = command === "";
  }

  showBranch(branch: number): void {
    if (branch < 0 || !this.page.layers.get("skeleton")?.branches) return fill(this.branch);
    const close = el("button", "plain", "Clear");
    close.addEventListener("click", () => this.onClearPick());
    fill(this.branch, el("header", "", el("h2", "", `Branch ${counted(branch)}`), close), rows(this.table.entries(branch)));
  }

  showSheet(sheet: number): void {
    if (sheet < 0 || !this.page.layers.get("skeleton")?.sheets) return fill(this.sheet);
    const close = el("button", "plain", "Clear");
    close.addEventListener("click", () => this.onClearPick());
    fill(this.sheet, el("header", "", el("h2", "", `Sheet ${counted(sheet)}`), close), rows(this.table.sheetEntries(sheet)));
  }

  showShare(text: string): void { this.share.textContent = text; }

  showPicked(picked: Picked | null): void {
    if (!picked) return fill(this.picked);
    const { unit } = this.page.meta;
    const close = el("button", "plain", "Clear");
    close.addEventListener("click", () => this.onClearPick());
    const entries: [string, string][] = [["position", picked.position.slice(0, this.page.meta.plane ? 2 : 3).map((x) => short(x, 5)).join(", ")]];
    for (const [name, value] of Object.entries(picked.measures)) entries.push([labelOf(name), Number.isNaN(value) ? "–" : withUnit(short(value, 4), Number.isFinite(value) ? unitOf(name, unit) : "")]);
    if (picked.vertex >= 0 && (this.page.shape.sites || this.page.shape.triangles)) entries.push([`${this.page.meta.plane ? "disk" : "ball"} touches`, `the ${this.page.meta.plane ? "outline" : "boundary"} at ${counted(picked.touching.length)} ${picked.touching.length === 1 ? "point" : "points"}`]);
    fill(this.picked, el("header", "", el("h2", "", picked.vertex < 0 ? "On the surface" : `Point ${counted(picked.vertex)}`), close), rows(entries));
  }
}

function topology(betti: number[], euler: number, plane: boolean): string {
  const words = [["component", "components"], plane ? ["hole", "holes"] : ["tunnel", "tunnels"], ["cavity", "cavities"]];
  const parts = betti.map((n, i) => (i < 3 && (n > 0 || i === 0) ? `${n} ${words[i]![n === 1 ? 0 : 1]}` : "")).filter((s) => s !== "");
  return `${parts.join(", ")} (χ = ${euler < 0 ? "−" : ""}${Math.abs(euler)})`;
}
