// SPDX-License-Identifier: Apache-2.0
// A table sorted by a click on a column, of which only the rows in sight are elements.
import { shortest32 } from "../format";
import { el, fill } from "./dom";

export interface Column { name: string; label: string; help: string; value: (row: number) => number | string; text: (row: number) => string }

const ROW = 24; // pixels

export class RowTable {
  readonly element: HTMLElement;
  order: number[]; ///< rows as they are sorted
  private readonly head = el("div", "branch-row branch-head");
  private readonly heads: HTMLElement[] = [];
  private readonly body = el("div", "branch-body");
  private readonly rows = el("div", "branch-rows");
  private sorted = -1;
  private falling = true;
  private picked = -1;
  private near = -1;

  /// `widths`: of the columns, as CSS has them; `least`: of all of it, pixels.
  constructor(private readonly columns: Column[], private readonly count: number, widths: string, least: number, sortBy: number, private readonly pick: (row: number) => void) {
    this.order = Array.from({ length: count }, (_, i) => i);
    const { head } = this;
    columns.forEach((column, i) => {
      const cell = el("button", "branch-cell", column.label);
      cell.title = column.help;
      cell.addEventListener("click", () => this.sort(i));
      this.heads.push(cell);
      head.append(cell);
    });
    this.body.append(this.rows);
    this.body.tabIndex = 0;
    this.body.addEventListener("keydown", (event) => {
      const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
      if (step === 0) return;
      event.preventDefault();
      event.stopPropagation();
      const at = this.order.indexOf(this.picked), next = this.order[Math.min(this.order.length - 1, Math.max(0, at + step))];
      if (next !== undefined) this.pick(next);
    });
    this.element = el("div", "branch-scroll", head, this.body);
    this.element.addEventListener("scroll", () => this.draw());
    this.element.style.setProperty("--columns", widths);
    this.element.style.setProperty("--least", `${least}px`);
    this.sort(sortBy);
  }

  /// Numbers fall at first, but those of rows; values that are no numbers come last.
  private sort(column: number): void {
    this.falling = column === this.sorted ? !this.falling : column !== 0;
    this.sorted = column;
    const { value } = this.columns[column]!, sign = this.falling ? -1 : 1, missing = (x: number | string) => Number(typeof x === "number" && Number.isNaN(x));
    this.order.sort((x, y) => {
      const a = value(x), b = value(y);
      return missing(a) - missing(b) || sign * (a < b ? -1 : a > b ? 1 : 0) || x - y;
    });
    this.heads.forEach((head, i) => { head.dataset.sorted = i === column ? (this.falling ? "▾" : "▴") : ""; });
    this.draw();
  }

  private get height(): number { return this.element.clientHeight - this.head.offsetHeight; }

  private draw(): void {
    this.rows.style.height = `${ROW * this.count}px`;
    const from = Math.max(0, Math.floor(this.element.scrollTop / ROW) - 4), to = Math.min(this.count, from + Math.ceil((this.height || 300) / ROW) + 8);
    fill(this.rows, ...this.order.slice(from, to).map((b, i) => {
      const row = el("button", "branch-row", ...this.columns.map((c) => el("span", "branch-cell", c.text(b))));
      row.style.top = `${ROW * (from + i)}px`;
      row.dataset.branch = String(b);
      row.classList.toggle("chosen", b === this.picked);
      row.classList.toggle("near", b === this.near);
      row.addEventListener("click", () => this.pick(b === this.picked ? -1 : b));
      return row;
    }));
  }

  /// `scroll`: to the row that is picked, where it is out of sight.
  show(picked: number, scroll: boolean): void {
    this.picked = picked;
    const at = this.order.indexOf(picked);
    if (scroll && at >= 0 && (ROW * at < this.element.scrollTop || ROW * (at + 1) > this.element.scrollTop + this.height)) this.element.scrollTop = ROW * at - this.height / 2;
    this.draw();
  }

  /// The row that the pointer is on elsewhere.
  showNear(row: number): void {
    if (row === this.near) return;
    this.near = row;
    this.draw();
  }

  /// The whole table in its order; infinity as `inf`, nothing where there is no value.
  csv(): string {
    const number = (x: number | string) => {
      if (typeof x === "number") return Number.isNaN(x) ? "" : Number.isFinite(x) ? shortest32(x) : x > 0 ? "inf" : "-inf";
      const text = x.replace(" – ", "-");
      return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
    };
    return [this.columns.map((c) => c.name).join(","), ...this.order.map((b) => this.columns.map((c) => number(c.value(b))).join(","))].join("\n") + "\n";
  }
}
