// SPDX-License-Identifier: Apache-2.0
// The table of the branches of the skeleton that was asked for: sorted by a click on a column, a row picks its branch.
// Only the rows in sight are elements.
import type { App } from "../app";
import { NODE_KINDS, type BranchMeasure, type Branches } from "../data";
import { short, withUnit } from "../format";
import { keyOf } from "../state";
import { el, fill } from "./dom";

interface Column { name: string; label: string; help: string; value: (b: number) => number | string; text: (b: number) => string }

const ROW = 24; // pixels

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
  private readonly heads: HTMLElement[] = [];
  private readonly body = el("div", "branch-body");
  private readonly rows = el("div", "branch-rows");
  private order: number[] = [];
  private sorted = 1;
  private falling = true;
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
    const head = el("div", "branch-row branch-head");
    this.columns.forEach((column, i) => {
      const cell = el("button", "branch-cell", column.label);
      cell.title = column.help;
      cell.addEventListener("click", () => this.sort(i));
      this.heads.push(cell);
      head.append(cell);
    });
    this.body.append(this.rows);
    this.body.tabIndex = 0;
    this.body.addEventListener("scroll", () => this.draw());
    this.body.addEventListener("keydown", (event) => {
      const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
      if (step === 0) return;
      event.preventDefault();
      event.stopPropagation();
      const at = this.order.indexOf(this.app.state.branch), next = this.order[Math.min(this.order.length - 1, Math.max(0, at + step))];
      if (next !== undefined) this.app.pickBranch(next);
    });
    const title = el("h2", "", `${b.count} ${b.count === 1 ? "branch" : "branches"}`);
    this.element.append(el("header", "", title, el("span", "branch-actions", copy, close)), el("div", "branch-scroll", head, this.body));
    this.sort(1);
  }

  /// In the plane there is one fire.
  private measures(): typeof BRANCH_COLUMNS {
    if (!this.app.page.meta.plane) return BRANCH_COLUMNS;
    return BRANCH_COLUMNS.map(([name, label, help, isLength]) => [name, label.replace("curve ", ""), help.replace("curve ", ""), isLength]);
  }

  private sort(column: number): void {
    this.falling = column === this.sorted ? !this.falling : column !== 0;
    if (this.order.length === 0) this.falling = true;
    this.sorted = column;
    const { value } = this.columns[column]!, sign = this.falling ? -1 : 1;
    this.order = Array.from({ length: this.branches!.count }, (_, i) => i).sort((x, y) => {
      const a = value(x), b = value(y);
      return sign * (a < b ? -1 : a > b ? 1 : 0) || x - y;
    });
    this.heads.forEach((head, i) => { head.dataset.sorted = i === column ? (this.falling ? "▾" : "▴") : ""; });
    this.draw();
  }

  private draw(): void {
    this.rows.style.height = `${ROW * this.order.length}px`;
    const from = Math.max(0, Math.floor(this.body.scrollTop / ROW) - 4), to = Math.min(this.order.length, from + Math.ceil((this.body.clientHeight || 300) / ROW) + 8);
    fill(this.rows, ...this.order.slice(from, to).map((b, i) => {
      const row = el("button", "branch-row", ...this.columns.map((c) => el("span", "branch-cell", c.text(b))));
      row.style.top = `${ROW * (from + i)}px`;
      row.dataset.branch = String(b);
      row.classList.toggle("chosen", b === this.picked);
      row.addEventListener("click", () => this.app.pickBranch(b === this.picked ? -1 : b));
      return row;
    }));
  }

  /// The whole table in its order; columns as in branches.csv, infinity as `inf`.
  csv(): string {
    const number = (x: number | string) => (typeof x === "string" ? x.replace(" – ", "-") : Number.isFinite(x) ? String(Number(x.toPrecision(9))) : "inf");
    return [this.columns.map((c) => c.name).join(","), ...this.order.map((b) => this.columns.map((c) => number(c.value(b))).join(","))].join("\n") + "\n";
  }

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
    const at = this.order.indexOf(this.picked);
    if (at >= 0 && (ROW * at < this.body.scrollTop || ROW * (at + 1) > this.body.scrollTop + this.body.clientHeight)) this.body.scrollTop = ROW * at - this.body.clientHeight / 2;
    this.draw();
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
