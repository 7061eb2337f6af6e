// SPDX-License-Identifier: Apache-2.0
// What a picture says of itself: file, thetas, detail, a scale bar, and axes on request. Drawn over the page and into
// pictures that are saved.
import { Vector3 } from "three";
import type { App } from "../app";
import { counted, short, withUnit } from "../format";
import { labelOf, pruningText, unitOf } from "../measures";
import { isAsked } from "../state";
import { el, prepare, styleOf } from "./dom";

const MARGIN = 24, BAR = 140; ///< pixels; the scale bar is at most so long
const AXES: [string, Vector3, string][] = [["x", new Vector3(1, 0, 0), "#d1495b"], ["y", new Vector3(0, 1, 0), "#3a9a4b"], ["z", new Vector3(0, 0, 1), "#3d6fd0"]];

export class Caption {
  readonly canvas = el("canvas", "caption");
  constructor(private readonly app: App) {}

  /// "armadillo · θ₂ = 0.03 mm · θ₁ = 0.02 mm · detail = 0.0017 mm".
  text(): string {
    const { state, page: { meta } } = this.app, length = (x: number) => (Number.isFinite(x) ? withUnit(short(x), meta.unit) : "∞");
    const radii = this.app.page.layers.has("skeleton") && isAsked(this.app.page, state) ? meta.theta1_radii : 0;
    const parts = [meta.title];
    if (state.layer === "skeleton") parts.push(...(meta.plane ? [] : [`θ₂ = ${length(state.theta2)}`]), `θ₁ = ${length(state.theta1)}${radii > 0 ? ` and ${short(radii)} radii` : ""}`);
    if (state.layer === "simple") parts.push(`medial mesh of ${counted(state.vertices)} vertices`);
    if (state.layer === "core") parts.push(`${labelOf(state.measure)} = ${withUnit(short(state.threshold), unitOf(state.measure, meta.unit))}`);
    else if (state.layer === "skeleton" && meta.pruning) parts.push(pruningText({ ...meta, voxel: undefined }));
    return parts.join(" · ");
  }

  /// A round length, and how many pixels it takes where the camera looks at.
  scaleBar(): { length: number; pixels: number } {
    const perPixel = this.app.stage.camera.perPixel * this.app.page.meta.side;
    const most = BAR * perPixel, power = 10 ** Math.floor(Math.log10(most));
    const length = power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
    return { length, pixels: length / perPixel };
  }

  /// `right`, `bottom`: how far the free part of the picture is from its sides.
  private draw(c: CanvasRenderingContext2D, width: number, height: number, right: number, bottom: number, whole: boolean): void {
    const { app } = this, { state, page: { meta } } = app;
    const { length, pixels } = this.scaleBar();
    c.font = "12px system-ui, sans-serif";
    c.fillStyle = c.strokeStyle = styleOf("--text");
    const x = width - right - MARGIN, y = height - bottom - MARGIN;
    c.textAlign = "center";
    c.fillText(withUnit(short(Number(length.toPrecision(3))), meta.unit), x - pixels / 2, y - 8);
    c.fillRect(x - pixels, y, pixels, 2);
    c.fillRect(x - pixels, y - 4, 1.5, 10);
    c.fillRect(x - 1.5, y - 4, 1.5, 10);
    if (whole) {
      c.textAlign = "left";
      c.font = "13px system-ui, sans-serif";
      c.fillText(this.text(), MARGIN, MARGIN + 4);
    }
    if (!state.axes) return;
    const { camera } = app.stage, cx = x - 34, cy = y - 66, size = 30;
    const seen = AXES.slice(0, meta.plane ? 2 : 3).map(([name, axis, colour]) => ({ name, colour, x: axis.dot(camera.right), y: axis.dot(camera.up), depth: axis.dot(camera.forward) }));
    for (const axis of seen.sort((a, b) => b.depth - a.depth)) {
      c.strokeStyle = c.fillStyle = axis.colour;
      c.lineWidth = 2;
      c.beginPath();
      c.moveTo(cx, cy);
      c.lineTo(cx + axis.x * size, cy - axis.y * size);
      c.stroke();
      c.textAlign = "center";
      c.font = "600 12px system-ui, sans-serif";
      c.fillText(axis.name, cx + axis.x * (size + 9), cy - axis.y * (size + 9) + 4);
    }
  }

  show(insets: { right: number; bottom: number }): void {
    const { stage, state } = this.app;
    this.canvas.hidden = !state.caption;
    if (!state.caption) return;
    this.canvas.style.width = `${stage.width}px`;
    this.draw(prepare(this.canvas, stage.width, stage.height), stage.width, stage.height, state.ui ? insets.right : 0, state.ui ? insets.bottom - MARGIN : 0, !state.ui);
  }

  /// The picture as a file, with the caption and the colour bar.
  picture(bars: { canvas: HTMLCanvasElement; title: string; shown: boolean }[]): string {
    const { stage, state } = this.app;
    if (!state.caption) return stage.picture();
    stage.draw();
    const out = el("canvas"), ratio = stage.canvas.width / stage.width;
    out.width = stage.canvas.width;
    out.height = stage.canvas.height;
    const c = out.getContext("2d")!;
    c.drawImage(stage.canvas, 0, 0);
    c.scale(ratio, ratio);
    this.draw(c, stage.width, stage.height, 0, 0, true);
    let below = 0;
    for (const bar of bars.filter((b) => b.shown).reverse()) {
      const height = bar.canvas.clientHeight, y = stage.height - MARGIN - height - below;
      below += height + 28;
      c.drawImage(bar.canvas, MARGIN - 14, y, bar.canvas.clientWidth, height);
      c.fillStyle = styleOf("--text");
      c.textAlign = "left";
      c.font = "600 13px system-ui, sans-serif";
      c.fillText(bar.title, MARGIN, y - 6);
    }
    return out.toDataURL("image/png");
  }
}
