// SPDX-License-Identifier: Apache-2.0
// Making elements.

type Child = Node | string | null | undefined;

export function el<K extends keyof HTMLElementTagNameMap>(tag: K, className = "", ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  if (className) element.className = className;
  for (const child of children) if (child != null) element.append(child);
  return element;
}

export function fill(element: Element, ...children: Child[]): void {
  element.replaceChildren(...children.filter((c): c is Node | string => c != null));
}

/// Rows of name and value.
export function rows(entries: [string, string][]): HTMLElement {
  const list = el("dl", "rows");
  for (const [name, value] of entries) list.append(el("dt", "", name), el("dd", "", value));
  return list;
}

/// A canvas as sharp as the screen; the drawing is in CSS pixels.
export function prepare(canvas: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  const ratio = Math.min(3, window.devicePixelRatio || 1);
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d")!;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}

export const styleOf = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
