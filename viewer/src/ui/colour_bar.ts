// SPDX-License-Identifier: Apache-2.0
// The colour bar: what colours mean, in world units.
import type { Layer } from "../data";
import { colourAt, css, GREY, INFINITE, type Rgb } from "../colours";
import { namesOf, ticks, withUnit } from "../format";
import { infinityOf, labelOf, unitOf, type Range } from "../measures";
import { el, fill, prepare, styleOf } from "./dom";

const LONG_TICK = 7; ///< letters of a number beside which no five others fit

export class ColourBar {
  readonly element = el("div", "colour-bar");
  private readonly title = el("div", "colour-title");
  private readonly canvas = el("canvas");
  private readonly keys = el("div", "colour-keys");

  constructor() { this.element.append(this.title, this.canvas, this.keys); }

  /// For pictures that are saved.
  figure(): { canvas: HTMLCanvasElement; title: string; shown: boolean } { return { canvas: this.canvas, title: this.title.textContent ?? "", shown: !this.canvas.hidden }; }

  hide(): void { this.element.hidden = true; }

  show(measure: string, lengths: string, map: string, low: number, high: number, range: Range | null, extra: [string, Rgb][], parts: [string, Rgb][], layer?: Layer, of = ""): void {
    this.element.hidden = false;
    const label = labelOf(measure) + of, unit = unitOf(measure, lengths, layer);
    const swatch = (name: string, rgb: Rgb) => {
      const dot = el("i", "swatch");
      dot.style.background = css(rgb);
      return el("span", "key", dot, name);
    };
    const keys = extra.map(([name, rgb]) => swatch(name, rgb));
    if (range && range.infinite > 0) keys.push(swatch(infinityOf(measure), INFINITE));
    if (range && range.missing > 0) keys.push(swatch(range.finite > 0 ? "no value here" : "no value anywhere", GREY));
    fill(this.keys, ...keys);
    const bar = range !== null && range.finite > 0;
    this.title.textContent = bar ? withUnit(label, unit && `(${unit})`) : "";
    this.title.hidden = this.canvas.hidden = !bar && parts.length === 0;
    if (parts.length > 0) this.legend(label, parts);
    if (!bar) return;
    const width = 280, height = 34;
    this.canvas.style.width = `${width}px`;
    const c = prepare(this.canvas, width, height), margin = 14, length = width - 2 * margin;
    const gradient = c.createLinearGradient(margin, 0, margin + length, 0);
    for (let i = 0; i <= 32; ++i) gradient.addColorStop(i / 32, css(colourAt(map, i / 32)));
    c.fillStyle = gradient;
    c.beginPath();
    c.rect(margin, 2, length, 10);
    c.fill();
    c.fillStyle = styleOf("--text");
    c.font = "12px system-ui, sans-serif";
    c.textAlign = "center";
    const flat = !(high > low);
    const placed = (most: number) => (flat ? [low] : ticks(low, high, most).map((x) => (Math.abs(x) < 1e-9 * Math.abs(high) ? 0 : x)));
    let places = placed(5), names = namesOf(places);
    if (names.some((name) => name.length > LONG_TICK)) names = namesOf((places = placed(2)));
    places.forEach((x, i) => {
      const at = margin + (flat ? 0.5 : (x - low) / (high - low)) * length;
      c.fillRect(at - 0.5, 13, 1, 4);
      c.fillText(names[i]!, at, 29);
    });
    // Values beyond the ends take their colours: arrow heads.
    const arrow = (from: number, to: number, t: number) => {
      c.fillStyle = css(colourAt(map, t));
      c.beginPath();
      c.moveTo(from, 2);
      c.lineTo(to, 7);
      c.lineTo(from, 12);
      c.fill();
    };
    if (range.low < low - 1e-6 * (high - low)) arrow(margin, margin - 8, 0);
    if (range.high > high + 1e-6 * (high - low)) arrow(margin + length, margin + length + 8, 1);
  }

  /// What the colours of parts mean.
  private legend(label: string, parts: [string, Rgb][]): void {
    const width = 280, row = 18, across = 3;
    this.title.textContent = label;
    this.canvas.style.width = `${width}px`;
    const c = prepare(this.canvas, width, row * Math.ceil(parts.length / across));
    c.font = "12px system-ui, sans-serif";
    parts.forEach(([name, rgb], i) => {
      const x = 14 + (i % across) * 88, y = row * Math.floor(i / across) + 3;
      c.fillStyle = css(rgb);
      c.fillRect(x, y, 11, 11);
      c.fillStyle = styleOf("--text");
      c.fillText(name, x + 17, y + 10);
    });
  }
}
