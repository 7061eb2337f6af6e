// SPDX-License-Identifier: Apache-2.0
// Starts the page: data, scene, controls, address, keys.
import { Vector3 } from "three";
import { App, type Numbers, type Picked } from "./app";
import { CATEGORICAL, MAPS, rgb, type Rgb } from "./colours";
import { PageError, readPage, type Page } from "./data";
import { Stage } from "./scene/stage";
import { defaults, fromHash, keyOf, layerOf, sanitize, toHash, type State } from "./state";
import { BranchTable } from "./ui/branches";
import { Burner } from "./ui/burner";
import { Caption } from "./ui/caption";
import { ColourBar } from "./ui/colour_bar";
import { el } from "./ui/dom";
import { Help } from "./ui/help";
import { Info } from "./ui/info";
import { listenToKeys } from "./ui/keys";
import { Panel } from "./ui/panel";
import { TreeInfo } from "./ui/tree_info";
import { TreeTable } from "./ui/tree_table";

const times: Record<string, number> = {};

interface Quench {
  ready: boolean;
  error: string | null;
  readonly state: State | null;
  times?: Record<string, number>;
  set(change: Partial<State>): void;
  sets(): Numbers;
  pick(vertex: number): Picked;
  branches(): string; ///< the table, as CSV
}
declare global { interface Window { quench: Quench } }

const root = document.getElementById("app")!;

function message(title: string, text: string): void {
  root.querySelector(".message")?.remove();
  root.append(el("div", "message", el("h1", "", title), el("p", "", text)));
}

function fail(error: unknown): void {
  const text = error instanceof PageError ? error.message : `This page does not work here: ${error instanceof Error ? error.message : String(error)}.`;
  window.quench.error = text;
  window.quench.ready = false;
  root.classList.add("broken");
  message("This page cannot be shown", text);
}

const none = () => { throw new PageError(window.quench.error ?? "The page is not ready."); };
window.quench = { ready: false, error: null, state: null, set: none, sets: none, pick: none, branches: none };

async function start(): Promise<void> {
  try {
    const wait = el("div", "message", el("p", "", "Unpacking …"));
    root.append(wait);
    const page = await readPage(document);
    times.read = performance.now();
    wait.remove();
    if (!page) {
      window.quench.error = "This page holds no result.";
      message("Quench", "This is the empty page. `quench view FILE... -o page.html` puts a result into it.");
      return;
    }
    run(page);
  } catch (error) {
    root.querySelector(".message")?.remove();
    fail(error);
  }
}

function run(page: Page): void {
  const dark = window.matchMedia?.("(prefers-color-scheme: dark)").matches ?? false;
  // Below the address comes what the page was written with, then the defaults.
  const written = fromHash(page.meta.state, defaults(page, dark));
  const base = sanitize(written.state, page);
  const first = fromHash(location.hash, base);
  const camera = first.camera ?? written.camera;
  const stage = new Stage(root);
  stage.onLost = (text) => fail(new PageError(text));
  const app = new App(page, stage, first.state);
  const { tree } = app;
  const help = new Help(page.meta.plane, tree !== null);
  const burner = new Burner(app);
  const table = new BranchTable(app);
  const caption = new Caption(app);
  const treeTable = tree && new TreeTable(app, tree), treeInfo = tree && treeTable && new TreeInfo(app, tree, treeTable);
  const info = new Info(page, table, treeInfo, () => help.toggle());
  const bar = new ColourBar(), surfaceBar = new ColourBar();
  const side = el("aside", "side");
  const screenshot = () => {
    const link = el("a");
    link.href = caption.picture([surfaceBar, bar].filter((b) => !b.element.hidden).map((b) => b.figure()));
    link.download = `${page.meta.title.replace(/[^\w.-]+/g, "_") || "quench"}.png`;
    link.click();
  };
  const reset = () => {
    if (written.camera) app.camera = written.camera;
    else app.lookFrom(null);
  };
  const panel = new Panel(app, side, burner, { screenshot, reset });
  info.meshes = panel.meshes;
  const left = el("div", "left", info.element, el("div", "bars", bar.element, surfaceBar.element));
  root.append(caption.canvas, left, table.element, ...(treeTable ? [treeTable.element] : []), side, info.command, ...(treeInfo ? [treeInfo.card] : []), help.element);
  info.onTable = () => app.set({ table: !app.state.table });
  info.onClearPick = () => app.pickBranch(-1);

  const theme = () => {
    const s = app.state;
    document.documentElement.dataset.theme = s.dark ? "dark" : "light";
    document.documentElement.style.setProperty("--accent", s.dark ? "#5bb7c5" : "#1f7f8c");
    root.classList.toggle("bare", !s.ui);
  };
  const tabled = () => app.state.table && (app.state.layer === "tree" || (keyOf(page, app.state) === "skeleton" && (page.layers.get("skeleton")?.branches ?? page.layers.get("skeleton")?.sheets) != null));
  const insets = () => {
    const { ui } = app.state, tall = tabled() ? Math.round(0.36 * window.innerHeight) : 0;
    if (!ui) return { left: 20, right: 20, top: 36, bottom: 16 };
    return window.innerWidth >= 900 ? { left: 290, right: 316, top: 20, bottom: 60 + tall } : { left: 8, right: 8, top: 56, bottom: Math.max(150, 8 + tall) };
  };
  const layout = () => stage.resize(window.innerWidth, window.innerHeight, insets());

  let hashTimer = 0;
  const remember = () => {
    window.clearTimeout(hashTimer);
    hashTimer = window.setTimeout(() => {
      const hash = toHash(app.state, base, app.camera);
      // A page in the frame of a notebook (about:srcdoc) has no address of its own to remember it in.
      if (location.protocol !== "about:" && hash !== location.hash.slice(1)) history.replaceState(null, "", `#${hash}`);
    }, 250);
  };

  let shape = `${app.state.ui}${tabled()}`;
  app.onChange = (numbers) => {
    const s = app.state;
    theme();
    if (shape !== `${s.ui}${tabled()}`) {
      shape = `${s.ui}${tabled()}`;
      layout();
    }
    info.show(s, numbers, app.command());
    info.showBranch(s.branch);
    info.showSheet(s.sheet);
    table.show();
    treeTable?.show();
    root.classList.toggle("tabled", !table.element.hidden || treeTable?.element.hidden === false);
    panel.show();
    burner.show();
    const extra: [string, Rgb][] = [];
    const map = MAPS[s.map] ?? MAPS.viridis!;
    if (s.curves && numbers.curveEdges > 0 && !s.balls && !s.curvesByMeasure && !s.color.startsWith("curve_") && app.range()) extra.push(["curves", rgb(s.map === "diverging" && s.dark ? "ffffff" : map.accent)]);
    const parts = (s.layer === "tree" && tree ? tree.partNames(s.color) : s.color === "sheet" ? app.sheetNames() : []).map((name, i): [string, Rgb] => [name, rgb(CATEGORICAL[i]!)]);
    if (app.surfaceIsSolid || (parts.length === 0 && !app.isColoured)) bar.hide(); // the surface hides the axis
    else bar.show(s.color, page.meta.unit, s.map, ...app.colourRange(), app.range(), extra, parts, layerOf(page, s));
    const surface = s.shape ? app.surfaceValues() : null;
    if (surface) surfaceBar.show(s.surface, page.meta.unit, s.map, ...app.surfaceRange(), surface, [], [], undefined, app.surfaceIsSolid ? "" : " of the surface");
    else surfaceBar.hide();
    remember();
  };
  app.onDrawn = () => caption.show(insets());
  app.onShare = (text) => info.showShare(text);
  app.onPick = (picked) => info.showPicked(picked);

  layout();
  theme();
  const place = () => {
    if (camera) app.camera = camera;
    else app.lookFrom(null);
  };
  place();
  let touched = false;
  const moved = () => {
    touched = true;
    app.stopFlight();
    if (app.state.clip && app.state.clipAxis === "view") app.set({});
    stage.invalidate();
    remember();
  };
  stage.camera.listen(stage.canvas, moved, (x, y) => app.pickAt(x, y));
  app.onMoved = remember;
  if (treeTable && treeInfo) {
    app.onNear = (branch, x, y) => {
      treeInfo.point(branch, x, y);
      treeTable.showNear(branch);
    };
    let asked = false, at: { x: number; y: number } | null = null;
    const point = (event: PointerEvent) => {
      at = event.type === "pointermove" && event.pointerType === "mouse" && event.buttons === 0 ? { x: event.clientX, y: event.clientY } : null;
      if (!asked) requestAnimationFrame(() => { asked = false; app.pointAt(at); });
      asked = true;
    };
    for (const kind of ["pointermove", "pointerdown", "pointerleave"] as const) stage.canvas.addEventListener(kind, point);
  }
  if (page.meta.plane)
    stage.canvas.addEventListener("dblclick", () => {
      reset();
      moved();
    });
  window.addEventListener("resize", () => {
    layout();
    if (!touched && !camera) app.frame();
    app.set({});
  });
  window.addEventListener("hashchange", () => {
    const now = fromHash(location.hash, base);
    if (now.camera) app.camera = now.camera;
    app.set(now.state);
  });
  window.matchMedia?.("(prefers-color-scheme: dark)").addEventListener("change", (event) => app.set({ dark: event.matches }));
  listenToKeys(app, panel, { burn: () => burner.toggle(), help, screenshot, reset, stepEdit: (direction) => treeInfo?.step(direction), look: (x, y, z) => app.lookFrom(new Vector3(x, y, z)), moved });

  stage.draw();
  Object.defineProperty(window.quench, "state", { get: () => ({ ...app.state }) });
  window.quench.set = (change) => { app.set(change); };
  window.quench.sets = () => { app.update(); return app.numbers(); };
  window.quench.pick = (vertex) => app.pick(vertex);
  window.quench.times = times;
  window.quench.branches = () => (treeTable && app.state.layer === "tree" ? treeTable.csv() : table.csv());
  document.title = page.meta.title;
  window.quench.ready = true;
  times.ready = performance.now();
  setTimeout(() => {
    app.slidersReady = true;
    panel.show();
    times.sliders = performance.now();
  }, 0);
}

if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", () => void start());
else void start();
