// SPDX-License-Identifier: Apache-2.0
// The overlay behind "?".
import { el } from "./dom";

/// What they do, and what in the plane where that is another thing; "": nothing.
/// Of trees only.
const TREE_KEYS: [string, string][] = [
  ["click", "pick an axis, or a branch where the table is that of branches, with its way to the root node"],
  [", .", "previous, next repair"],
  ["M", "marks of repairs"],
  ["L", "lines, tubes"],
  ["0", "tree"],
];

const KEYS: [string, string, string?][] = [
  ["drag", "turn", "move"],
  ["right drag, Shift + drag", "move", ""],
  ["scroll, + −", "zoom"],
  ["double click", "", "whole view again"],
  ["arrow keys", "turn in steps", "move in steps"],
  ["click", "pick a point (its ball, and where it touches) and the branch or sheet it is on", "pick a point (its disk, and where it touches) and the branch it is on"],
  ["Esc", "clear what is picked"],
  ["[ ]", "θ₂ of the skeleton, pruning of the medial axis: less, more", "θ₁ of the skeleton, pruning of the medial axis: less, more"],
  ["; '", "θ₁: less, more", ""],
  ["[ ]", "of a medial mesh: fewer vertices, more", ""],
  ["1 2 3 4", "skeleton, medial axis, other result, medial mesh", "skeleton, medial axis, other result"],
  ["T", "table of branches and sheets"],
  ["S C E B", "sheets, curves, seams, boundary", ""],
  ["C", "", "curves"],
  ["G", "surface of the shape", "shape"],
  ["U", "union of balls, of a medial mesh its envelope", "union of disks"],
  ["X", "clipping plane", ""],
  ["Space", "burn"],
  ["O", "orthographic, perspective", ""],
  ["F", "whole view again"],
  ["A", "axes"],
  ["X Y Z with Alt", "look along an axis", ""],
  ["D", "dark, light"],
  ["H", "hide panels"],
  ["P", "save a picture"],
  ["?", "this help"],
];

export class Help {
  readonly element = el("div", "help");
  constructor(plane: boolean, tree: boolean) {
    const list = el("dl", "keys");
    for (const [key, inSpace, inPlane] of KEYS) {
      const meaning = plane ? (inPlane ?? inSpace) : inSpace;
      if (meaning) list.append(el("dt", "", key), el("dd", "", meaning));
    }
    if (tree) list.prepend(...TREE_KEYS.flatMap(([key, meaning]) => [el("dt", "", key), el("dd", "", meaning)]));
    const close = el("button", "plain", "Close");
    close.addEventListener("click", () => this.toggle(false));
    const box = el("div", "help-box", el("h2", "", "Keys and mouse"), list,
      el("p", "", `Touch: one finger ${plane ? "moves, two move and zoom" : "turns, two move, zoom and roll"}, a tap picks. The address of the page holds the view: copy it to share what you see.`), close);
    box.setAttribute("role", "dialog");
    this.element.append(box);
    this.element.hidden = true;
    this.element.addEventListener("click", (event) => event.target === this.element && this.toggle(false));
  }
  toggle(on = this.element.hidden): void { this.element.hidden = !on; }
  get open(): boolean { return !this.element.hidden; }
}
