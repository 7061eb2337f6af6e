// SPDX-License-Identifier: Apache-2.0
// The table of the branches of the skeleton that was asked for; a row picks its branch.
import type { App } from "../app";
import { NODE_KINDS, type BranchMeasure, type Branches } from "../data";
import { short, withUnit } from "../format";
import { keyOf } from "../state";
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
  private readonly columns: Column[] = [];
  private readonly table: RowTable | null = null;
  private picked = -1;

  constructor(private readonly app: App) {
    const { page } = app, { unit } = page.meta;
    this.branches = page.layers.get("skeleton")?.branches ?? null;
    this.element.hidden = true;
    const b = this.branches;
    if (!b) return;
    const kind = (branch: number, end: number) => NODE_KINDS[b.nodeKinds[b.nodes[2 * branch + end]!]!] ?? "";
    this.columns.push({ name: "branch", label: "branch", help: "Number, as in branches.csv", value: (i) => i, text: String });
    for (const [name, label, help, isLength] of this.measures())
      this.columns.push({ name, label: isLength && unit ? `${label} (${unit})` : label, help, value: (i) => b.measures[name][i]!, text: (i) => short(b.measures[name][i]!, 4) });
    this.columns.push({ name: "ends", label: "ends", help: "What is at its ends: an end, a junction, a sheet, or a loop closes", value: (i) => `${kind(i, 0)} – ${kind(i, 1)}`, text: (i) => `${kind(i, 0)} – ${kind(i, 1)}` });
    const copy = el("button", "plain", "Copy as CSV"), close = el("button", "plain", "Close");
    copy.addEventListener("click", () => void copyText(this.csv(), copy));
    close.addEventListener("click", () => app.set({ table: false }));
    this.table = new RowTable(this.columns, b.count, "66px repeat(6, minmax(84px, 1fr)) minmax(130px, 1.4fr)", 720, 1, (branch) => app.pickBranch(branch));
    const title = el("h2", "", `${b.count} ${b.count === 1 ? "branch" : "branches"}`);
    this.element.append(el("header", "", title, el("span", "branch-actions", copy, close)), this.table.element);
  }

  /// In the plane there is one fire.
  private measures(): typeof BRANCH_COLUMNS {
    if (!this.app.page.meta.plane) return BRANCH_COLUMNS;
    return BRANCH_COLUMNS.map(([name, label, help, isLength]) => [name, label.replace("curve ", ""), help.replace("curve ", ""), isLength]);
  }

  csv(): string { return this.table?.csv() ?? ""; }

  /// What the table says of a branch, for the panel of what is picked.
  entries(branch: number): [string, string][] {
    const { unit } = this.app.page.meta, b = this.branches!;
    const ends = this.columns[this.columns.length - 1]!.text(branch);
    return [...this.measures().map(([name, label, , isLength]): [string, string] => [label, withUnit(short(b.measures[name][branch]!, 4), isLength && Number.isFinite(b.measures[name][branch]!) ? unit : "")]), ["ends", ends]];
  }

  show(): void {
    const { state } = this.app;
    const was = this.element.hidden;
    this.element.hidden = !this.branches || !state.table || !state.ui || keyOf(this.app.page, state) !== "skeleton";
    if (this.element.hidden) return;
    if (was === this.element.hidden && this.picked === state.branch) return;
    this.picked = state.branch;
    this.table!.show(this.picked, true);
  }
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
