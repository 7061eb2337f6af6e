// SPDX-License-Identifier: Apache-2.0
// The figures of a tree, what is picked of it, and the way through its repairs; and the card beside the pointer.
import type { App } from "../app";
import { CATEGORICAL, EDIT_COLOURS, type EditGroup } from "../colours";
import { counted, short, withUnit } from "../format";
import { textOf, unitText } from "../table";
import { groupOf, type Rows, type Tree } from "../tree";
import { el, fill, rows as rowsOf } from "./dom";
import { rowName, rowsText, type TreeTable } from "./tree_table";

/// What of a row is said first: of an axis, of a branch.
const CARD = ["class", "level", "parent", "children", "length", "mean radius", "tortuosity", "parent angle", "gravity angle", "tip depth", "strahler", "bridged length"];
const MOST_ON_CARD = 7, MOST_LEVELS = 12;
const GROUPS: Record<EditGroup, [string, string]> = { bridges: ["bridge", "bridges"], cuts: ["cut", "cuts"], leftOut: ["part left out", "parts left out"] };

export class TreeInfo {
  readonly element = el("div", "tree-info");
  readonly card = el("div", "near-card");
  private readonly chosen = el("div", "chosen-branch");
  private readonly chosenEdit = el("div", "chosen-branch chosen-edit");
  private readonly at = el("span", "edit-at");
  private readonly swatches: HTMLElement[] = [];
  private readonly toTable = el("button", "plain to-table");
  private shown = "";

  constructor(private readonly app: App, private readonly tree: Tree, private readonly table: TreeTable) {
    this.card.hidden = true;
    this.element.append(this.figures(), this.levels());
    this.toTable.addEventListener("click", () => app.set({ table: !app.state.table }));
    if (tree.tables.sample.length > 0) {
      const all = el("details", "about", el("summary", "", "All traits of the sample"), rowsOf(tree.tables.sample.map((c): [string, string] => [c.name.replaceAll("_", " "), this.value(c.name)])));
      all.querySelectorAll("dt").forEach((dt, i) => { dt.title = tree.tables.sample[i]!.meaning; });
      this.element.append(all);
    }
    if (tree.editCount > 0) this.element.append(this.stepper());
    this.element.append(this.toTable);
    this.element.append(this.chosenEdit, this.chosen);
  }

  private value(name: string): string {
    const c = this.tree.column("sample", name)!, text = textOf(c, 0, short);
    return text === "–" ? text : withUnit(text, unitText(c.unit));
  }

  private figures(): HTMLElement {
    const { tree } = this, { unit } = this.app.page.meta, entries: [string, string][] = [];
    const plants = new Set(tree.axisParent.filter((p) => p === 0xffffffff)).size && tree.axisParent.filter((p) => p === 0xffffffff).length;
    if (plants > 1) entries.push(["plants", counted(plants)]);
    const length = tree.sample("total_length"), depth = tree.sample("depth");
    const sum = tree.levels.reduce((all, level) => all + level.length, 0);
    entries.push(["axes", `${counted(tree.axisCount)} in ${counted(tree.branchCount)} ${tree.branchCount === 1 ? "branch" : "branches"}`]);
    entries.push(["total length", withUnit(short(Number.isNaN(length) ? sum : length, 4), unit)], ["depth", withUnit(short(Number.isNaN(depth) ? tree.depth : depth, 4), unit)]);
    return rowsOf(entries);
  }

  /// Axes and length per level as bars in the colours of the levels.
  private levels(): HTMLElement {
    const { levels } = this.tree, { unit } = this.app.page.meta, longest = Math.max(...levels.map((l) => l.length), 1e-300);
    const list = el("div", "levels");
    levels.slice(0, MOST_LEVELS).forEach(({ axes, length }, level) => {
      const bar = el("i", "level-bar");
      bar.style.width = `${Math.max(1, (100 * length) / longest)}%`;
      bar.dataset.colour = `#${CATEGORICAL[level % CATEGORICAL.length]}`;
      this.swatches.push(bar);
      const row = el("div", "level-row", el("span", "level-name", `level ${level}`), el("span", "level-count", counted(axes)), el("span", "level-track", bar), el("span", "level-length", withUnit(short(length), unit)));
      row.title = `${counted(axes)} ${axes === 1 ? "axis" : "axes"} of level ${level}, together ${withUnit(short(length, 4), unit)}`;
      list.append(row);
    });
    if (levels.length > MOST_LEVELS) list.append(el("div", "level-row", el("span", "level-name", `… to level ${levels.length - 1}`)));
    return list;
  }

  private stepper(): HTMLElement {
    const { app, tree } = this, counts: Record<EditGroup, number> = { bridges: 0, cuts: 0, leftOut: 0 };
    for (let i = 0; i < tree.editCount; ++i) ++counts[groupOf(tree.kind(i))];
    const keys = (Object.keys(counts) as EditGroup[]).filter((name) => counts[name] > 0).map((name) => {
      const dot = el("i", "edit-dot"), box = el("button", "edit-key", dot, `${counted(counts[name])} ${GROUPS[name][counts[name] === 1 ? 0 : 1]}`);
      dot.style.background = `#${EDIT_COLOURS[name]}`;
      box.dataset.group = name;
      box.title = "Show or hide their marks";
      box.addEventListener("click", () => app.set({ [name]: !app.state[name] }));
      return box;
    });
    const step = (text: string, direction: number, help: string) => {
      const button = el("button", "plain", text);
      button.title = help;
      button.addEventListener("click", () => this.step(direction));
      return button;
    };
    const list = el("button", "plain", "List");
    list.title = "The table of repairs";
    list.addEventListener("click", () => app.set({ rows: "edits", table: true }));
    return el("div", "edits", el("div", "edit-keys", ...keys), el("div", "edit-steps", step("‹", -1, "Previous repair (,)"), step("›", 1, "Next repair (.)"), list, this.at));
  }

  step(direction: number): void { if (this.tree.editCount > 0) this.app.stepEdit(direction, this.table.order); }

  show(): void {
    const { state } = this.app, { tree } = this;
    this.element.hidden = state.layer !== "tree";
    this.toTable.textContent = `${state.table ? "Hide the table" : "Table"} of ${rowsText("axes", tree.axisCount)}`;
    this.swatches.forEach((bar) => { bar.style.background = state.color === "level" ? bar.dataset.colour! : "var(--faint)"; });
    this.element.querySelectorAll<HTMLElement>(".edit-key").forEach((key) => key.setAttribute("aria-pressed", String(state[key.dataset.group as EditGroup])));
    const rows: Rows = state.rows === "branches" ? "branches" : "axes", row = this.app.pickedRow(rows), key = `${rows} ${row} ${state.edit}`;
    if (key === this.shown) return;
    this.shown = key;
    const shownEdits = this.app.editsShown(this.table.order);
    this.at.textContent = state.edit >= 0 && tree.editCount > 0 ? `${counted(shownEdits.indexOf(state.edit) + 1)} of ${counted(shownEdits.length)}` : "";
    this.fillCard(this.chosenEdit, "edits", state.edit, () => this.app.set({ edit: -1 }));
    this.fillCard(this.chosen, rows, row, () => this.app.set({ axis: -1, branch: -1 }));
  }

  private fillCard(card: HTMLElement, rows: Rows, row: number, clear: () => void): void {
    if (row < 0) return fill(card);
    const close = el("button", "plain", "Clear"), name = rowName(rows);
    close.addEventListener("click", clear);
    const all = this.table.entries(rows, row).filter(([label]) => label !== name && label !== "edit" && label !== "id");
    const wanted = this.wanted(all), rest = all.filter((entry) => !wanted.includes(entry)), more = el("details", "about", el("summary", "", "All of its row"), rowsOf(rest));
    more.open = card.querySelector("details")?.open ?? false;
    fill(card, el("header", "", el("h2", "", `${name[0]!.toUpperCase()}${name.slice(1)} ${counted(row)}`), close), rowsOf(wanted), rest.length > 0 ? more : null);
  }

  /// The main figures; all where there are few of these.
  private wanted(all: [string, string][]): [string, string][] {
    const wanted = CARD.map((name) => all.find(([label]) => label === name)).filter((entry) => entry !== undefined);
    return wanted.length > 1 ? wanted : all;
  }

  /// Beside the pointer: what it is on, a few figures.
  point(branch: number, x: number, y: number): void {
    this.card.hidden = branch < 0;
    if (branch < 0) return;
    const rows: Rows = this.app.state.rows === "branches" ? "branches" : "axes", row = rows === "axes" ? this.tree.branchAxis[branch]! : branch;
    fill(this.card, el("h2", "", `${rowName(rows)} ${counted(row)}`), rowsOf(this.wanted(this.table.entries(rows, row).slice(1)).slice(0, MOST_ON_CARD)));
    const right = x + 18 + this.card.offsetWidth < window.innerWidth, below = y + 18 + this.card.offsetHeight < window.innerHeight;
    this.card.style.left = `${right ? x + 18 : x - 12 - this.card.offsetWidth}px`;
    this.card.style.top = `${below ? y + 18 : y - 12 - this.card.offsetHeight}px`;
  }
}
