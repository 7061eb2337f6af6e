// SPDX-License-Identifier: Apache-2.0
// The burning over time: a time slider and a play button.
import type { App } from "../app";
import { short, withUnit } from "../format";
import { pruningText } from "../measures";
import { el } from "./dom";

const SECONDS = 8; // of the whole animation

export class Burner {
  readonly element = el("div", "burner");
  private readonly button = el("button", "plain play", "▶");
  private readonly range = el("input", "range");
  private readonly text = el("span", "others");
  private playing = false;
  private last = 0;

  constructor(private readonly app: App) {
    this.range.type = "range";
    this.range.min = "0";
    this.range.max = "1000";
    this.range.setAttribute("aria-label", "Time of the fire");
    this.range.addEventListener("input", () => {
      this.playing = false;
      app.set({ burn: this.range.value !== "0", time: (Number(this.range.value) / 1000) * this.end });
    });
    this.button.title = "Burn (Space)";
    this.button.addEventListener("click", () => this.toggle());
    this.element.append(el("div", "burner-row", this.button, this.range), this.text);
  }

  get possible(): boolean { return this.app.burnRange() !== null; }
  private get end(): number { return (this.app.burnRange()?.[1] ?? 0) * 1.02 + this.app.page.meta.side * 0.015; }

  toggle(): void {
    if (!this.possible) return;
    this.playing = !this.playing;
    this.last = performance.now();
    if (this.playing) {
      const { state } = this.app;
      const first = Math.max(0, (this.app.burnRange()?.[0] ?? 0) - this.app.page.meta.side * 0.012);
      this.app.set({ burn: true, time: !state.burn || state.time >= this.end * 0.999 ? first : state.time });
      requestAnimationFrame((now) => this.tick(now));
    } else this.app.set({});
    this.show();
  }

  private tick(now: number): void {
    if (!this.playing) return;
    const step = (Math.min(100, Math.max(0, now - this.last)) / 1000 / SECONDS) * this.end;
    this.last = now;
    const time = Math.min(this.end, this.app.state.time + step);
    if (time >= this.end) this.playing = false;
    this.app.set({ time });
    if (this.playing) requestAnimationFrame((next) => this.tick(next));
  }

  show(): void {
    const { state, page } = this.app;
    this.button.textContent = this.playing ? "❚❚" : "▶";
    if (!this.possible) return void (this.text.textContent = "No burn times in this layer.");
    this.range.value = state.burn ? String(Math.round((state.time / this.end) * 1000)) : "0";
    const burned = page.meta.pruning ? ` The axis burned was pruned at ${pruningText(page.meta)}.` : "";
    this.text.textContent = state.burn ? `time ${withUnit(short(state.time), page.meta.unit)} of ${short(this.app.burnRange()![1])}.${burned}` : `Fire starts at the ${page.meta.plane ? "free ends of the curves" : "rims of the sheets"}.${burned}`;
  }
}
