// SPDX-License-Identifier: Apache-2.0
// The keyboard; ui/help.ts lists what is here.
import type { App } from "../app";
import type { LayerName } from "../data";
import { hasLayer, type State } from "../state";
import type { Help } from "./help";
import type { Panel } from "./panel";

interface Actions {
  burn: () => void;
  help: Help;
  screenshot: () => void;
  reset: () => void;
  stepEdit: (direction: number) => void;
  look: (x: number, y: number, z: number) => void;
  moved: () => void;
}

export function listenToKeys(app: App, panel: Panel, actions: Actions): void {
  const flip = (key: keyof State) => () => app.set({ [key]: !app.state[key] });
  const layer = (name: LayerName) => () => hasLayer(app.page, name) && app.set({ layer: name });
  const turn = (dx: number, dy: number) => () => {
    const { camera } = app.stage;
    if (camera.plane) camera.pan(-dx, -dy);
    else camera.rotate(dx, dy);
    actions.moved();
  };
  const zoom = (factor: number) => () => {
    app.stage.camera.zoom(factor, app.stage.width / 2, app.stage.height / 2);
    actions.moved();
  };
  const step = (of: "sheets" | "curves", direction: number) => () => panel.step(of, direction);
  const keys: Record<string, () => unknown> = {
    "?": () => actions.help.toggle(),
    Escape: () => (actions.help.open ? actions.help.toggle(false) : app.clearPick()),
    "0": layer("tree"), "1": layer("skeleton"), "2": layer("core"), "3": layer("still"), "4": layer("simple"),
    s: flip("sheets"), c: flip("curves"), e: flip("seams"), b: flip("boundary"), g: flip("shape"), u: flip("balls"), x: flip("clip"),
    t: flip("table"), a: flip("axes"), o: flip("orthographic"), d: flip("dark"), h: flip("ui"), p: actions.screenshot, f: actions.reset, " ": actions.burn,
    l: () => app.tree && app.set({ tubes: !app.state.tubes }), ",": () => actions.stepEdit(-1), ".": () => actions.stepEdit(1),
    m: () => {
      const on = !(app.state.bridges || app.state.cuts);
      if (app.edits) app.set({ bridges: on, cuts: on, leftOut: false });
    },
    "[": step("sheets", -1), "]": step("sheets", 1), ";": step("curves", -1), "'": step("curves", 1),
    ArrowLeft: turn(-30, 0), ArrowRight: turn(30, 0), ArrowUp: turn(0, -30), ArrowDown: turn(0, 30),
    "+": zoom(0.88), "=": zoom(0.88), "-": zoom(1 / 0.88),
  };
  const axes: Record<string, [number, number, number]> = { KeyX: [1, 0, 0], KeyY: [0, 1, 0], KeyZ: [0, 0, 1] };
  window.addEventListener("keydown", (event) => {
    const target = event.target instanceof HTMLElement ? event.target : null;
    if (event.ctrlKey || event.metaKey || target?.closest("input:not([type=range]):not([type=checkbox]), select, textarea")) return;
    const onControl = target?.closest("input, button, summary") != null;
    if (onControl && (event.key === " " || event.key.startsWith("Arrow"))) return;
    const axis = event.altKey && !app.page.meta.plane ? axes[event.code] : undefined;
    if (axis) {
      const sign = event.shiftKey ? -1 : 1;
      actions.look(sign * axis[0], sign * axis[1], sign * axis[2]);
      event.preventDefault();
      return;
    }
    if (event.altKey) return;
    const action = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
