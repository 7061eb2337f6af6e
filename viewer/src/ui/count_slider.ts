// SPDX-License-Identifier: Apache-2.0
// A slider for the number of vertices of a medial mesh, with the curve of its error where that is known.
import type { Collapses } from "../collapses";
import type { Meta } from "../data";
import { counted, short, withUnit } from "../format";
import { el, prepare, styleOf } from "./dom";

const STEPS = 1000;

export class CountSlider {
  readonly element: HTMLElement;
  private readonly range = el("input", "range");
  private readonly field = el("input", "field");
  private readonly others = el("span", "others");
  private readonly canvas = el("canvas", "histogram");
  private value = 0;

  constructor(private readonly meshes: Collapses, private readonly meta: Meta, private readonly changed: (count: number) => void) {
    this.range.type = "range";
    this.range.min = "0";
    this.range.max = String(STEPS);
    this.range.step = "1";
    this.range.setAttribute("aria-label", "Vertices");
    this.range.addEventListener("input", () => changed(this.countAt(Number(this.range.value) / STEPS)));
    this.field.type = "text";
    this.field.inputMode = "numeric";
    this.field.setAttribute("aria-label", "Number of vertices");
    this.field.addEventListener("change", () => {
      const count = Number(this.field.value.replace(/\s/g, ""));
      if (this.field.value.trim() === "" || Number.isNaN(count)) this.show(this.value);
      else changed(count);
    });
    this.element = el("div", "slider", el("div", "slider-head", el("label", "slider-label", "N vertices"), this.field, el("span", "unit", "")), el("div", "slider-body", this.canvas, this.range), this.others);
    this.element.dataset.id = "vertices";
    this.element.title = "Medial meshes with fewer and fewer vertices, all with the topology of the finest; curve: how far the boundary is from their envelope, on average.";
  }

  private position(count: number): number {
    const { least, most } = this.meshes;
    return most > least ? Math.log(count / least) / Math.log(most / least) : 1;
  }
  private countAt(position: number): number {
    const { least, most } = this.meshes;
    return Math.round(least * (most / least) ** position);
  }

  show(count: number): void {
    this.value = count;
    this.range.value = String(Math.round(this.position(count) * STEPS));
    if (document.activeElement !== this.field) this.field.value = String(count);
    const { least, most } = this.meshes;
    this.others.textContent = count === most ? "the finest in this page" : count === least ? "fewer would change the topology, or are not here" : `${counted(least)} to ${counted(most)}`;
    this.draw();
  }

  /// One step of the keyboard.
  step(direction: number): void {
    const next = this.countAt(Math.min(1, Math.max(0, this.position(this.value) + direction * 0.02)));
    this.changed(next === this.value ? this.value + direction : next);
  }

  /// What is known of the error.
  errorText(count: number): string {
    const error = this.meshes.error(count);
    if (!error) return "";
    const length = (x: number) => withUnit(short(x), this.meta.unit);
    return `${error.exact ? "" : "about "}${length(error.mean)} on average, 99 % below ${length(error.most99)}, ${length(error.largest)} at most`;
  }

  private draw(): void {
    const width = this.canvas.clientWidth || 260, height = 30, c = prepare(this.canvas, width, height), at = this.position(this.value) * width;
    const rows = this.meshes.errorRows.filter((row) => row.values[0] > 0), logs = rows.map((row) => Math.log(row.values[0])), low = Math.min(...logs), high = Math.max(...logs);
    c.fillStyle = styleOf("--faint");
    c.fillRect(0, height - 1, width, 1);
    if (rows.length > 1) {
      c.strokeStyle = styleOf("--accent");
      c.lineWidth = 1.5;
      c.beginPath();
      rows.forEach((row, i) => {
        const x = this.position(row.vertices) * width, y = high > low ? 3 + ((high - logs[i]!) / (high - low)) * (height - 8) : height / 2;
        if (i === 0) c.moveTo(x, y);
        else c.lineTo(x, y);
      });
      c.stroke();
    }
    c.fillStyle = styleOf("--text");
    c.fillRect(Math.min(width - 1.5, at - 0.75), 0, 1.5, height);
  }
}
