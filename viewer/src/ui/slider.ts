// SPDX-License-Identifier: Apache-2.0
// A slider for a threshold with the histogram of what it cuts: number field in world units, of lengths the same in % and
// voxels.
import type { Meta } from "../data";
import { exact, parseLength, short } from "../format";
import { histogram, LogScale } from "../histogram";
import { elementOf } from "../measures";
import { el, prepare, styleOf } from "./dom";

const BINS = 72, STEPS = 1000;

export interface SliderOptions {
  id: string;
  label: string;
  help: string;
  meta: Meta;
  unit: string;
  isLength: boolean;
  floor: number;
  asked: number; ///< what the page was written for; NaN: nothing
  values: Float32Array; ///< what is compared
  weight: (i: number) => number;
  infinite: boolean;
  changed: (x: number) => void;
}

export class LengthSlider {
  readonly element: HTMLElement;
  private readonly scale: LogScale;
  private readonly range = el("input", "range");
  private readonly field = el("input", "field");
  private readonly others = el("span", "others");
  private readonly canvas = el("canvas", "histogram");
  private readonly bins: Float64Array;
  private value = 0;

  constructor(private readonly options: SliderOptions) {
    let top = 0, least = Infinity;
    for (const x of options.values)
      if (Number.isFinite(x)) {
        if (x > top) top = x;
        if (x > 0 && x < least) least = x;
      }
    const { meta } = options;
    const smallest = Math.max(Number.isFinite(least) ? least : 0, (meta.voxel ?? meta.side / 256) / 8);
    if (Number.isFinite(options.asked)) top = Math.max(top, 1.5 * options.asked); // its handle is not that of infinity
    this.scale = new LogScale(options.floor, top > 0 ? top : meta.side / 10, smallest);
    this.bins = histogram(this.scale, options.values, options.weight, BINS);
    this.range.type = "range";
    this.range.min = "0";
    this.range.max = String(STEPS);
    this.range.step = "1";
    this.range.setAttribute("aria-label", options.label);
    this.range.addEventListener("input", () => {
      const step = Number(this.range.value);
      options.changed(step === this.stepOf(options.asked) ? options.asked : this.scale.value(step / STEPS, options.infinite));
    });
    this.field.type = "text";
    this.field.inputMode = "decimal";
    this.field.spellcheck = false;
    this.field.setAttribute("aria-label", `${options.label}${options.unit ? ` in ${options.unit}` : ""}`);
    this.field.addEventListener("change", () => {
      const x = parseLength(this.field.value);
      if (Number.isNaN(x)) this.show(this.value);
      else options.changed(x);
    });
    const head = el("div", "slider-head", el("label", "slider-label", options.label), this.field, el("span", "unit", options.unit));
    this.element = el("div", "slider", head, el("div", "slider-body", this.canvas, this.range), this.others);
    this.element.dataset.id = options.id;
    this.element.title = options.help;
  }

  private stepOf(x: number): number { return Math.round(this.scale.position(x) * STEPS); }

  show(x: number): void {
    this.value = x;
    this.range.value = String(this.stepOf(x));
    if (document.activeElement !== this.field) this.field.value = Number.isFinite(x) ? String(Number(exact(x)).toPrecision(4)).replace(/\.?0+$/, (z) => (z.startsWith(".") ? "" : z)) : "inf";
    const { meta, isLength, floor } = this.options, parts: string[] = [];
    if (!Number.isFinite(x)) parts.push("infinite");
    else if (isLength) parts.push(`${short((100 * x) / meta.side)} % of the side`, ...(meta.voxel ? [`${short(x / meta.voxel)} ${elementOf(meta)}s`] : []));
    if (x === this.options.asked) parts.push("as asked");
    else if (x === floor && x > 0) parts.push("slider begins here");
    this.others.textContent = parts.join(" · ");
    this.draw();
  }

  /// One step of the keyboard.
  step(direction: number): void {
    this.options.changed(this.scale.value(Math.min(1, Math.max(0, this.scale.position(this.value) + direction * 0.02)), this.options.infinite));
  }

  draw(): void {
    const width = this.canvas.clientWidth || 260, height = 30;
    const c = prepare(this.canvas, width, height);
    const most = Math.max(...this.bins, 1e-300);
    const at = this.scale.position(this.value);
    const kept = styleOf("--accent"), cut = styleOf("--faint");
    const step = width / BINS;
    for (let i = 0; i < BINS; ++i) {
      const room = this.options.infinite && i === BINS - 1 ? height - 13 : height - 2; // the sign above it
      const h = this.bins[i]! > 0 ? Math.max(1.5, Math.sqrt(this.bins[i]! / most) * room) : 0;
      c.fillStyle = (i + 1) / BINS > at ? kept : cut;
      c.fillRect(i * step, height - h, Math.max(1, step - 1), h);
    }
    c.fillStyle = styleOf("--text");
    c.fillRect(Math.min(width - 1.5, at * width - 0.75), 0, 1.5, height);
    if (this.options.infinite) {
      c.fillStyle = styleOf("--quiet");
      c.font = "11px system-ui, sans-serif";
      c.textAlign = "center";
      c.fillText("∞", ((1 + LogScale.END) / 2) * width, 10);
    }
  }
}
