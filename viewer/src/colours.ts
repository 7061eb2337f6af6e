// SPDX-License-Identifier: Apache-2.0
// Colour maps that people with any colour vision can read, and the colours that are no values.

export type Rgb = [number, number, number];

interface ColourMap {
  label: string;
  stops: string[];
  /// Of curves drawn in one colour: far from every colour of the map.
  accent: string;
}

// The darkest ends of the maps are left out: nothing of the light on a sheet would be seen there.
export const MAPS: Record<string, ColourMap> = {
  viridis: { label: "viridis", stops: ["46206f", "443a83", "355f8d", "2a788e", "21918c", "22a884", "44bf70", "7ad151", "bddf26", "fde725"], accent: "f4511e" },
  cividis: { label: "cividis", stops: ["00224e", "123570", "3b496c", "575d6d", "707173", "8a8678", "a59c74", "c3b369", "e1cc55", "fee838"], accent: "e8432e" },
  magma: { label: "magma", stops: ["51127c", "6a1c81", "8c2981", "b73779", "de4968", "f7705c", "fe9f6d", "fecf92", "fcfdbf"], accent: "19b5c9" },
  diverging: { label: "blue – red", stops: ["2166ac", "4393c3", "92c5de", "d1e5f0", "f2f2f2", "fddbc7", "f4a582", "d6604d", "b2182b"], accent: "2f2f35" },
};

/// Of parts that are told apart by their colour: a number has the colour of its remainder (shaders.ts).
export const CATEGORICAL = ["4e79a7", "f28e2b", "59a14f", "e15759", "76b7b2", "edc948", "b07aa1", "ff9da7", "9c755f", "2f9fd0", "a0cb50", "8064d0"];

/// Repairs of a tree.
export type EditGroup = "bridges" | "cuts" | "leftOut";
export const EDIT_COLOURS: Record<EditGroup, string> = { bridges: "00b8d9", cuts: "e5195f", leftOut: "8c8f94" };

export const GREY: Rgb = rgb("8c8f94"); ///< no value
export const INFINITE: Rgb = rgb("cc79a7"); ///< no fire comes

export function rgb(hex: string): Rgb {
  const n = parseInt(hex.replace("#", ""), 16);
  return [((n >> 16) & 255) / 255, ((n >> 8) & 255) / 255, (n & 255) / 255];
}

export function css([r, g, b]: Rgb): string {
  return `rgb(${Math.round(r * 255)} ${Math.round(g * 255)} ${Math.round(b * 255)})`;
}

/// The colour at 0 .. 1.
export function colourAt(map: string, t: number): Rgb {
  const stops = (MAPS[map] ?? MAPS.viridis!).stops;
  const x = Math.min(1, Math.max(0, t)) * (stops.length - 1);
  const i = Math.min(stops.length - 2, Math.floor(x));
  const a = rgb(stops[i]!), b = rgb(stops[i + 1]!);
  return [0, 1, 2].map((k) => a[k]! + (b[k]! - a[k]!) * (x - i)) as Rgb;
}

/// 256 texels, RGBA.
export function textureOf(map: string, parts = false): Uint8Array<ArrayBuffer> {
  const texels = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; ++i) {
    const c = parts ? rgb(CATEGORICAL[Math.floor((i / 256) * CATEGORICAL.length)]!) : colourAt(map, i / 255);
    for (let k = 0; k < 3; ++k) texels[4 * i + k] = Math.round(255 * c[k]!);
    texels[4 * i + 3] = 255;
  }
  return texels;
}

/// In textures of measures, where arithmetic on infinities and NaN is not sure: what they are written as.
export const CODE_INFINITE = 1e30;
export const CODE_MISSING = -1e30;
export function encode(x: number): number {
  return Number.isNaN(x) ? CODE_MISSING : Number.isFinite(x) ? x : CODE_INFINITE;
}
