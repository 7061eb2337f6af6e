// SPDX-License-Identifier: Apache-2.0
// The controls on the right.
import GUI, { type Controller } from "lil-gui";
import type { App } from "../app";
import { MAPS } from "../colours";
import type { LayerName } from "../data";
import { isLength, labelOf, measuresOf, pruningBy, UNIFORM, unitOf } from "../measures";
import { askedThetas, hasLayer, isAsked, layerOf, slidersOf, type SliderId, type State } from "../state";
import type { Burner } from "./burner";
import { el } from "./dom";
import { CountSlider } from "./count_slider";
import { LengthSlider } from "./slider";

export interface Actions { screenshot: () => void; reset: () => void }

const LAYERS: Record<LayerName, string> = { tree: "tree", skeleton: "skeleton", core: "medial axis (core)", simple: "medial mesh", still: "other result (still)" };

export class Panel {
  readonly gui: GUI;
  private readonly sliders = new Map<string, { id: SliderId; slider: LengthSlider }>();
  private shownSliders: SliderId[] = [];
  private readonly fields: State;
  private readonly controllers: Controller[] = [];
  private colour!: Controller;
  private readonly folders: Record<string, GUI> = {};
  readonly meshes: CountSlider | null; ///< of medial meshes
  private readonly sliderBox = el("div", "sliders");
  private readonly asked = el("button", "plain asked", "Back to the skeleton asked for");
  private shownKey = "";
  private readonly measure: Controller | null;

  constructor(private readonly app: App, container: HTMLElement, burner: Burner, actions: Actions) {
    this.fields = { ...app.state };
    this.gui = new GUI({ container, title: "Controls", width: 300 });
    const { page } = app, { plane } = page.meta;
    const names = (Object.keys(LAYERS) as LayerName[]).filter((name) => hasLayer(page, name));
    if (names.length > 1) this.add(this.gui, "layer", "show", Object.fromEntries(names.map((n) => [LAYERS[n], n])));
    const { measures } = page.meta;
    this.measure = measures.length > 1 && page.layers.has("core") ? this.add(this.gui, "measure", "prune by", Object.fromEntries(measures.map((m) => [labelOf(m.name), m.name]))) : null;
    this.gui.$children.append(this.sliderBox);
    const collapses = page.layers.get("simple")?.collapses;
    this.meshes = collapses ? new CountSlider(collapses, page.meta, (vertices) => app.set({ vertices })) : null;
    this.asked.addEventListener("click", () => {
      const [theta2, theta1] = askedThetas(page.meta);
      app.set({ theta2, theta1 });
    });

    const colour = this.folder("Colour");
    this.colour = this.add(colour, "color", "colour by", {});
    this.add(colour, "map", "colours", Object.fromEntries(Object.entries(MAPS).map(([k, m]) => [m.label, k])));
    const lines = [...page.layers.values()].every((layer) => layer.faceCount === 0), { tree } = app;
    if (!plane && !lines) this.add(colour, "curvesByMeasure", "curves too");
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
    const onlyTree = names.length === 1 && tree !== null;
    if (tree) this.add(parts, "tubes", "tubes");
    if (!plane && !lines) this.add(parts, "sheets", "sheets");
    if (!onlyTree) this.add(parts, "curves", "curves");
    if (!plane && !lines) this.add(parts, "seams", "seams");
    if (!plane && !lines) this.add(parts, "boundary", "boundary");
    if (!onlyTree) this.add(parts, "points", "points");
    const skeleton = page.layers.get("skeleton");
    if (tree || skeleton?.branches || skeleton?.sheets) this.add(parts, "table", tree || skeleton?.sheets ? "table" : "branches");
    if (app.edits) for (const [name, label] of [["bridges", "bridges"], ["cuts", "cuts"], ["leftOut", "left out"]] as const) if (app.edits.count(name) > 0) this.add(parts, name, label);
    this.add(parts, "curveWidth", "curve width").min(1).max(14).step(0.5);

    const around = this.folder(plane ? "Shape" : "Shape and space");
    if (app.glass ?? app.figure) {
      this.add(around, "shape", plane ? "shape" : "surface");
      this.add(around, "shapeOpacity", "opacity").min(0).max(1).step(0.01);
      if (app.glass && page.shape.measures.size > 0) this.add(around, "surface", "surface by", Object.fromEntries([UNIFORM, ...page.shape.measures.keys()].map((name) => [labelOf(name), name])));
    }
    this.add(around, "balls", plane ? "union of disks" : "union of balls");
    if (!plane) this.add(around, "clip", "clip");
    this.clipping = plane ? [] : [
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
    if (!plane) this.add(view, "orthographic", "orthographic");
    this.add(view, "dark", "dark");
    this.add(view, "axes", "axes");
    this.add(view, "caption", "caption");
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

  private keyOf(id: SliderId): string { return id === "threshold" ? `${id}/${this.app.state.measure}` : id; }

  private slider(id: SliderId): LengthSlider | null {
    const existing = this.sliders.get(this.keyOf(id));
    if (existing) return existing.slider;
    const { meta } = this.app.page, { measure } = this.app.state, ofCore = id === "threshold";
    const sets = this.app.setsOf(ofCore ? "core" : "family");
    if (!sets) return null;
    const { layer } = sets;
    const floor = ofCore ? meta.measures.find((m) => m.name === measure)!.floor : meta.floor[id];
    const common = { id, meta, floor, unit: ofCore ? unitOf(measure, meta.unit) : meta.unit, isLength: !ofCore || isLength(measure), asked: ofCore ? NaN : askedThetas(meta)[id === "theta2" ? 0 : 1], changed: (x: number) => this.app.set({ [id]: x }) };
    let slider: LengthSlider | null = null;
    if (id === "theta1") {
      if (!layer.curveEdges || !layer.curveThickness) return null;
      const edges = layer.curveEdges;
      slider = new LengthSlider({ ...common, label: meta.plane ? "θ₁" : "θ₁ curves", help: "Prunes curves whose erosion thickness is smaller, from their free ends. Histogram: length of curves.", infinite: true, values: layer.curveThickness, weight: (i) => sets.edgeLength(edges[i]!) });
    } else if (meta.plane && layer.edgeLevel)
      slider = new LengthSlider({
        ...common, label: labelOf(measure), infinite: false, values: layer.edgeLevel, weight: (e) => sets.edgeLength(e),
        help: `${pruningBy(measure)}, where the topology allows. Histogram: length of the axis.`,
      });
    else if (layer.faceLevel)
      slider = new LengthSlider({
        ...common, label: ofCore ? labelOf(measure) : "θ₂ sheets", infinite: !ofCore, values: layer.faceLevel, weight: (f) => sets.faceArea(f),
        help: `${ofCore ? pruningBy(measure) : "Drops sheets whose erosion thickness is smaller"}, where the topology allows. Histogram: area of sheets.`,
      });
    if (slider) this.sliders.set(this.keyOf(id), { id, slider });
    return slider;
  }

  /// Moves the slider of the sheets or the curves shown.
  step(of: "sheets" | "curves", direction: number): void {
    if (this.app.state.layer === "simple") return this.meshes?.step(direction);
    const [first, last] = [this.shownSliders[0], this.shownSliders.at(-1)], id = of === "sheets" ? first : last === "theta1" ? last : undefined;
    if (id) this.slider(id)?.step(direction);
  }

  /// Brings everything up to date with the state.
  show(): void {
    const { state } = this.app;
    const key = `${state.layer}/${state.measure}/${this.app.slidersReady}`;
    if (this.shownKey !== key) {
      this.shownKey = key;
      const names = measuresOf(this.app.page.layers.get(state.layer) ?? layerOf(this.app.page, state));
      this.colour = this.colour.options(Object.fromEntries([...names, UNIFORM].map((n) => [labelOf(n), n])));
      this.shownSliders = slidersOf(this.app.page, state);
      this.sliderBox.replaceChildren(...(state.layer === "simple" && this.meshes ? [this.meshes.element] : []), ...this.shownSliders.flatMap((id) => this.slider(id)?.element ?? []), ...(this.shownSliders.includes("theta1") && this.app.page.layers.has("skeleton") ? [this.asked] : []));
      this.measure?.show(state.layer === "core");
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
    for (const id of this.shownSliders) this.slider(id)?.show(state[id]);
    if (state.layer === "simple") this.meshes?.show(state.vertices);
    this.asked.hidden = isAsked(this.app.page, state);
  }
}
