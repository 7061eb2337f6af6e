// SPDX-License-Identifier: Apache-2.0
// The controls on the right.
import GUI, { type Controller } from "lil-gui";
import type { App } from "../app";
import { MAPS } from "../colours";
import type { LayerName } from "../data";
import { labelOf, measuresOf, UNIFORM } from "../measures";
import type { State } from "../state";
import type { Burner } from "./burner";
import { el } from "./dom";
import { LengthSlider } from "./slider";

export interface Actions { screenshot: () => void; reset: () => void }

const LAYERS: Record<LayerName, string> = { skeleton: "skeleton", core: "medial axis", still: "complex" };

export class Panel {
  readonly gui: GUI;
  readonly sliders = new Map<"lambda" | "theta2" | "theta1", LengthSlider>();
  private readonly fields: State;
  private readonly controllers: Controller[] = [];
  private colour!: Controller;
  private readonly folders: Record<string, GUI> = {};
  private readonly sliderBox = el("div", "sliders");
  private measuresOfLayer: LayerName | null = null;

  constructor(private readonly app: App, container: HTMLElement, burner: Burner, actions: Actions) {
    this.fields = { ...app.state };
    this.gui = new GUI({ container, title: "Controls", width: 300 });
    const { page } = app;
    const names = [...page.layers.keys()];
    if (names.length > 1) this.add(this.gui, "layer", "show", Object.fromEntries(names.map((n) => [LAYERS[n], n])));
    this.gui.$children.append(this.sliderBox);

    const colour = this.folder("Colour");
    this.colour = this.add(colour, "color", "sheets by", {});
    this.add(colour, "map", "colours", Object.fromEntries(Object.entries(MAPS).map(([k, m]) => [m.label, k])));
    this.add(colour, "curvesByMeasure", "curves too");
    const range = {
      low: 0, high: 1,
      fit: () => {
        const [rangeLow, rangeHigh] = app.visibleRange() ?? [NaN, NaN];
        app.set({ rangeLow, rangeHigh });
      },
      auto: () => app.set({ rangeLow: NaN, rangeHigh: NaN }),
    };
    this.rangeFields = range;
    this.rangeControllers = [
      colour.add(range, "low").name("from").onFinishChange((x: number) => app.set({ rangeLow: x })),
      colour.add(range, "high").name("to").onFinishChange((x: number) => app.set({ rangeHigh: x })),
    ];
    colour.add(range, "fit").name("fit to what is visible");
    this.auto = colour.add(range, "auto").name("as at first");

    const parts = this.folder("Parts");
    parts.domElement.classList.add("pairs");
    this.add(parts, "sheets", "sheets");
    this.add(parts, "curves", "curves");
    this.add(parts, "seams", "seams");
    this.add(parts, "boundary", "boundary");
    this.add(parts, "points", "points");
    this.add(parts, "curveWidth", "curve width").min(1).max(14).step(0.5);

    const around = this.folder("Shape and space");
    if (app.glass) {
      this.add(around, "shape", "shape around");
      this.add(around, "shapeOpacity", "opacity").min(0).max(1).step(0.01);
    }
    this.add(around, "balls", "union of balls");
    this.add(around, "clip", "clip");
    this.clipping = [
      this.add(around, "clipAxis", "across", { x: "x", y: "y", z: "z", "line of sight": "view" }),
      this.add(around, "clipAt", "at").min(0).max(1).step(0.001),
      this.add(around, "clipFlip", "other side"),
    ];

    if (burner.possible) {
      const burning = this.folder("Burning");
      burning.$children.append(burner.element);
      this.add(burning, "burnHides", "hide what burned");
    }

    const view = this.folder("View");
    view.domElement.classList.add("pairs");
    this.add(view, "orthographic", "orthographic");
    this.add(view, "dark", "dark");
    view.add(actions, "reset").name("whole view (F)");
    view.add(actions, "screenshot").name("picture (P)");
    if (window.innerHeight < 900) for (const name of ["Parts", "Burning"]) this.folders[name]?.close();
    if (window.innerWidth < 720) this.gui.close();
  }
  private rangeFields: { low: number; high: number };
  private rangeControllers: Controller[];
  private clipping: Controller[];
  private auto: Controller;

  private folder(title: string): GUI { return (this.folders[title] = this.gui.addFolder(title)); }

  private add(gui: GUI, key: keyof State, label: string, options?: Record<string, string>): Controller {
    const controller = options ? gui.add(this.fields, key, options) : gui.add(this.fields, key);
    controller.name(label).onChange((value: State[typeof key]) => this.app.set({ [key]: value }));
    this.controllers.push(controller);
    return controller;
  }

  private slider(id: "lambda" | "theta2" | "theta1"): LengthSlider | null {
    const existing = this.sliders.get(id);
    if (existing) return existing;
    const { meta } = this.app.page, { sets } = this.app.shown(), { layer } = sets;
    const common = { id, meta, floor: meta.floor[id], changed: (x: number) => this.app.set({ [id]: x }) };
    let slider: LengthSlider | null = null;
    if (id === "theta1") {
      if (!layer.curveEdges || !layer.curveThickness) return null;
      const edges = layer.curveEdges;
      slider = new LengthSlider({ ...common, label: "θ₁ curves", help: "Prunes curves whose erosion thickness is smaller, from their free ends. Histogram: length of curves.", infinite: true, values: layer.curveThickness, weight: (i) => sets.edgeLength(edges[i]!) });
    } else if (layer.faceLevel)
      slider = new LengthSlider({
        ...common, label: id === "lambda" ? "λ" : "θ₂ sheets", infinite: id === "theta2", values: layer.faceLevel, weight: (f) => sets.faceArea(f),
        help: id === "lambda" ? "Prunes what is thinner than this radius, where the topology allows. Histogram: area of sheets." : "Drops sheets whose erosion thickness is smaller, where the topology allows. Histogram: area of sheets.",
      });
    if (slider) this.sliders.set(id, slider);
    return slider;
  }

  /// Brings everything up to date with the state.
  show(): void {
    const { state } = this.app;
    if (this.measuresOfLayer !== state.layer) {
      this.measuresOfLayer = state.layer;
      const names = measuresOf(this.app.page.layers.get(state.layer)!);
      this.colour = this.colour.options(Object.fromEntries([...names, UNIFORM].map((n) => [labelOf(n), n])));
      const wanted = state.layer === "core" ? (["lambda"] as const) : state.layer === "skeleton" ? (["theta2", "theta1"] as const) : [];
      this.sliderBox.replaceChildren(...wanted.flatMap((id) => this.slider(id)?.element ?? []));
    }
    Object.assign(this.fields, state);
    for (const controller of this.controllers) controller.updateDisplay();
    [this.rangeFields.low, this.rangeFields.high] = this.app.colourRange().map((x) => Number(x.toPrecision(4))) as [number, number];
    for (const controller of this.rangeControllers) {
      controller.updateDisplay();
      controller.enable(this.app.range() !== null);
    }
    this.auto.show(Number.isFinite(state.rangeLow) || Number.isFinite(state.rangeHigh));
    for (const controller of this.clipping) controller.show(state.clip);
    for (const [id, slider] of this.sliders) if (slider.element.isConnected) slider.show(state[id]);
  }
}
