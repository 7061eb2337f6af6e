// SPDX-License-Identifier: Apache-2.0
// The tables of a tree: its axes, its branches, and where it was repaired.
import type { App } from "../app";
import { counted, short, withUnit } from "../format";
import { textOf, unitText } from "../table";
import { ROWS, type Rows, type Tree } from "../tree";
import { copyText } from "./branches";
import { el } from "./dom";
import { RowTable, type Column } from "./row_table";

const NAMES: Record<Rows, [string, string]> = { axes: ["axis", "axes"], branches: ["branch", "branches"], edits: ["repair", "repairs"] };
const SORTED = ["length"]; ///< by what a table is sorted at first

export const rowsText = (rows: Rows, count: number): string => `${counted(count)} ${NAMES[rows][count === 1 ? 0 : 1]}`;
export const rowName = (rows: Rows): string => NAMES[rows][0];

export class TreeTable {
  readonly element = el("section", "branches");
  private readonly tables = new Map<Rows, RowTable>();
  private readonly columns = new Map<Rows, Column[]>();
  private readonly tabs = new Map<Rows, HTMLButtonElement>();
  private readonly place = el("div", "branch-place");
  private shown = "";

  constructor(private readonly app: App, private readonly tree: Tree) {
    this.element.hidden = true;
    const tabs = el("span", "branch-tabs");
    for (const rows of ROWS) {
      if (tree.count(rows) === 0) continue;
      const tab = el("button", "plain", rowsText(rows, tree.count(rows)));
      tab.addEventListener("click", () => app.set({ rows }));
      this.tabs.set(rows, tab);
      tabs.append(tab);
    }
    const copy = el("button", "plain", "Copy as CSV"), close = el("button", "plain", "Close");
    copy.addEventListener("click", () => void copyText(this.csv(), copy));
    close.addEventListener("click", () => app.set({ table: false }));
    this.element.append(el("header", "", tabs, el("span", "branch-actions", copy, close)), this.place);
  }

  private columnsOf(rows: Rows): Column[] {
    let columns = this.columns.get(rows);
    if (columns) return columns;
    const { tree } = this;
    columns = tree.tables[rows].map((c): Column => ({
      name: c.name, label: c.name.replaceAll("_", " ") + (c.unit ? ` (${unitText(c.unit)})` : ""), help: c.meaning,
      value: (i) => (c.words ? (c.words[c.values[i]!] ?? "") : c.values[i]!), text: (i) => (rows === "edits" ? textOf(c, i, short).replaceAll("_", " ") : textOf(c, i, short)),
    }));
    if (rows === "edits") {
      const { origin, unit } = this.app.page.meta, at = (i: number, k: number) => (tree.editPoints[6 * i + k]! + tree.editPoints[6 * i + 3 + k]!) / 2 + origin[k]!;
      columns.unshift({ name: "edit", label: "repair", help: "Number, as in edits.csv", value: (i) => i, text: String });
      ["x", "y", "z"].forEach((name, k) => columns!.push({ name, label: unit ? `${name} (${unit})` : name, help: "Its middle", value: (i) => Math.fround(at(i, k)), text: (i) => short(at(i, k), 5) }));
    } else if (!columns.some((c) => c.name === rowName(rows) || c.name === "id")) columns.unshift({ name: rowName(rows), label: rowName(rows), help: "Number", value: (i) => i, text: String });
    this.columns.set(rows, columns);
    return columns;
  }

  private table(rows: Rows): RowTable {
    let table = this.tables.get(rows);
    if (!table) {
      const columns = this.columnsOf(rows), first = Math.max(0, columns.findIndex((c) => SORTED.includes(c.name)));
      table = new RowTable(columns, this.tree.count(rows), `66px repeat(${columns.length - 1}, minmax(88px, 1fr))`, 66 + 88 * (columns.length - 1) + 24, rows === "edits" ? 0 : first, (row) => this.app.pickRow(rows, row));
      this.tables.set(rows, table);
    }
    return table;
  }

  get rows(): Rows { return this.app.state.rows; }
  get order(): number[] { return this.table("edits").order; }
  csv(): string { return this.table(this.rows).csv(); }

  /// What the table says of a row, with units.
  entries(rows: Rows, row: number): [string, string][] {
    const { tree } = this, table = tree.tables[rows], list = this.columnsOf(rows), place = rows === "edits" ? list.slice(-3) : [];
    const of = (c: Column) => c.name.replaceAll("_", " ");
    const entries = list.filter((c) => !place.includes(c)).map((c): [string, string] => {
      const unit = unitText(table.find((t) => t.name === c.name)?.unit ?? ""), text = c.text(row);
      return [of(c), text === "–" ? text : withUnit(text, unit)];
    });
    return place.length > 0 ? [...entries, ["place", place.map((c) => c.text(row)).join(", ")]] : entries;
  }

  show(): void {
    const { state } = this.app, row = this.app.pickedRow(), was = this.element.hidden;
    this.element.hidden = !state.table || !state.ui || state.layer !== "tree";
    if (this.element.hidden) return;
    if (!this.tabs.has(state.rows)) return this.app.set({ rows: "axes" });
    const key = `${state.rows} ${row}`;
    if (!was && key === this.shown) return;
    this.shown = key;
    const table = this.table(state.rows);
    if (this.place.firstChild !== table.element) this.place.replaceChildren(table.element);
    for (const [rows, tab] of this.tabs) tab.setAttribute("aria-pressed", String(rows === state.rows));
    table.show(row, true);
  }

  /// The pointer is on a branch in the picture; -1: on none.
  showNear(branch: number): void {
    if (this.element.hidden || this.rows === "edits") return;
    this.table(this.rows).showNear(branch >= 0 && this.rows === "axes" ? this.tree.branchAxis[branch]! : branch);
  }
}
