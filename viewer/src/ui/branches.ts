// SPDX-License-Identifier: Apache-2.0
// The tables of the branches and sheets of the skeleton that was asked for; a row picks its branch or sheet.
import type { App } from "../app";
import { NODE_KINDS, type BranchMeasure, type Branches, type Sheets } from "../data";
import { counted, short, withUnit } from "../format";
import { keyOf, LISTS, type List } from "../state";
import { textOf, unitText } from "../table";
import { el } from "./dom";
import { RowTable, type Column } from "./row_table";

/// Measures of a branch: the names of branches.csv, what they are called, and whether they are lengths.
export const BRANCH_COLUMNS: [BranchMeasure, string, string, boolean][] = [
  ["length", "length", "Length along the branch", true],
  ["mean_radius", "mean radius", "Mean distance to the boundary, along the length", true],
  ["min_radius", "min radius", "Smallest distance to the boundary", true],
  ["max_radius", "max radius", "Largest distance to the boundary", true],
  ["thickness", "curve erosion thickness", "Largest curve erosion thickness on it: how far it sticks out; infinite on loops", true],
  ["tortuosity", "tortuosity", "Length over distance of the ends", false],
];

export class BranchTable {
  readonly element = el("section", "branches");
  private readonly branches: Branches | null;
  private readonly sheets: Sheets | null;
  private readonly columns: Record<List, Column[]> = { branches: [], sheets: [] };
  private readonly tables = new Map<List, RowTable>();
  private readonly tabs = new Map<List, HTMLButtonElement>();
  private readonly place = el("div", "branch-place");
  private shown = "";

  constructor(private readonly app: App) {
    const { page } = app, skeleton = page.layers.get("skeleton");
    this.branches = skeleton?.branches ?? null;
    this.sheets = skeleton?.sheets ?? null;
    this.element.hidden = true;
    if (this.branches) this.columns.branches = this.columnsOfBranches(this.branches);
    if (this.sheets) this.columns.sheets = columnsOfSheets(this.sheets);
    const lists = LISTS.filter((list) => this.columns[list].length > 0);
    if (lists.length === 0) return;
    const tabs = el("span", "branch-tabs");
    for (const list of lists) {
      const tab = el("button", "plain", listText(list, this.count(list)));
      tab.addEventListener("click", () => app.set({ list }));
      this.tabs.set(list, tab);
      tabs.append(tab);
    }
    const copy = el("button", "plain", "Copy as CSV"), close = el("button", "plain", "Close");
    copy.addEventListener("click", () => void copyText(this.csv(), copy));
    close.addEventListener("click", () => app.set({ table: false }));
    const title = lists.length > 1 ? tabs : el("h2", "", listText(lists[0]!, this.count(lists[0]!)));
    this.element.append(el("header", "", title, el("span", "branch-actions", copy, close)), this.place);
  }

  count(list: List): number { return (list === "branches" ? this.branches?.count : this.sheets?.count) ?? 0; }

  private columnsOfBranches(b: Branches): Column[] {
    const { unit } = this.app.page.meta;
    const kind = (branch: number, end: number) => NODE_KINDS[b.nodeKinds[b.nodes[2 * branch + end]!]!] ?? "";
    const columns: Column[] = [{ name: "branch", label: "branch", help: "Number, as in branches.csv", value: (i) => i, text: String }];
    for (const [name, label, help, isLength] of this.measures())
      columns.push({ name, label: isLength && unit ? `${label} (${unit})` : label, help, value: (i) => b.measures[name][i]!, text: (i) => short(b.measures[name][i]!, 4) });
    columns.push({ name: "ends", label: "ends", help: "What is at its ends: an end, a junction, a sheet, or a loop closes", value: (i) => `${kind(i, 0)} – ${kind(i, 1)}`, text: (i) => `${kind(i, 0)} – ${kind(i, 1)}` });
    return columns;
  }

  private table(list: List): RowTable {
    let table = this.tables.get(list);
    if (!table) {
      const columns = this.columns[list];
      table = list === "branches"
        ? new RowTable(columns, this.count(list), "66px repeat(6, minmax(84px, 1fr)) minmax(130px, 1.4fr)", 720, 1, (branch) => this.app.pickBranch(branch))
        : new RowTable(columns, this.count(list), `66px repeat(${columns.length - 1}, minmax(92px, 1fr))`, 66 + 92 * (columns.length - 1) + 24, Math.max(1, columns.findIndex((c) => c.name === "area")), (sheet) => this.app.pickSheet(sheet));
      this.tables.set(list, table);
    }
    return table;
  }

  /// In the plane there is one fire.
  private measures(): typeof BRANCH_COLUMNS {
    if (!this.app.page.meta.plane) return BRANCH_COLUMNS;
    return BRANCH_COLUMNS.map(([name, label, help, isLength]) => [name, label.replace("curve ", ""), help.replace("curve ", ""), isLength]);
  }

  csv(): string { return this.tabs.has(this.app.state.list) ? this.table(this.app.state.list).csv() : ""; }

  /// What the table says of a branch, for the panel of what is picked.
  entries(branch: number): [string, string][] {
    const { unit } = this.app.page.meta, b = this.branches!, { branches } = this.columns;
    const ends = branches[branches.length - 1]!.text(branch);
    return [...this.measures().map(([name, label, , isLength]): [string, string] => [label, withUnit(short(b.measures[name][branch]!, 4), isLength && Number.isFinite(b.measures[name][branch]!) ? unit : "")]), ["ends", ends]];
  }

  /// The same of a sheet.
  sheetEntries(sheet: number): [string, string][] {
    return (this.sheets?.columns ?? []).filter((c) => c.name !== "sheet").map((c): [string, string] => {
      const text = textOf(c, sheet, short);
      return [c.name.replaceAll("_", " "), text === "–" || text === "∞" ? text : withUnit(text, unitText(c.unit))];
    });
  }

  show(): void {
    const { state } = this.app, { list } = state, picked = list === "sheets" ? state.sheet : state.branch;
    const was = this.element.hidden, layer = keyOf(this.app.page, state);
    this.element.hidden = !this.tabs.has(list) || !state.table || !state.ui || layer !== "skeleton";
    if (this.element.hidden) return;
    const key = `${list}/${picked}`;
    if (was === this.element.hidden && this.shown === key) return;
    this.shown = key;
    const table = this.table(list);
    if (table.element.parentElement !== this.place) this.place.replaceChildren(table.element);
    for (const [name, tab] of this.tabs) tab.classList.toggle("chosen", name === list);
    table.show(picked, true);
  }
}

const NAMES: Record<List, [string, string]> = { branches: ["branch", "branches"], sheets: ["sheet", "sheets"] };
export const listText = (list: List, count: number): string => `${counted(count)} ${NAMES[list][count === 1 ? 0 : 1]}`;

function columnsOfSheets(sheets: Sheets): Column[] {
  const columns = sheets.columns.map((c): Column => ({
    name: c.name, label: c.name.replaceAll("_", " ") + (c.unit ? ` (${unitText(c.unit)})` : ""), help: c.meaning,
    value: (i) => (c.words ? (c.words[c.values[i]!] ?? "") : c.values[i]!), text: (i) => textOf(c, i, short),
  }));
  if (!columns.some((c) => c.name === "sheet")) columns.unshift({ name: "sheet", label: "sheet", help: "Number, as in parts.csv", value: (i) => i, text: String });
  return columns;
}

/// To the clipboard; pages opened from a file have none in some browsers.
export async function copyText(text: string, button: HTMLButtonElement): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = el("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  const label = button.textContent;
  button.textContent = "Copied";
  setTimeout(() => (button.textContent = label), 1500);
}
