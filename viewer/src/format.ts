// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them.

/// Three or four significant digits, no exponent where it can be avoided.
export function short(x: number, digits = 3): string {
  if (Number.isNaN(x)) return "–";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  if (x === 0) return "0";
  const size = Math.abs(x);
  const text = size >= 1e6 || size < 1e-5 ? x.toExponential(digits - 1) : size >= 10 ** digits ? Math.round(x).toString() : String(Number(x.toPrecision(digits)));
  return text.replace("-", "−");
}

/// For the address and commands: as many digits as a float32 has, `inf` for infinity.
export function exact(x: number): string {
  if (!Number.isFinite(x)) return x > 0 ? "inf" : "-inf";
  return String(Number(x.toPrecision(9)));
}

export function parseLength(text: string): number {
  const word = text.trim().toLowerCase();
  if (word === "inf" || word === "infinity" || word === "∞") return Infinity;
  return word === "" ? NaN : Number(word.replace("−", "-"));
}

export const withUnit = (text: string, unit: string): string => (unit ? `${text} ${unit}` : text);

/// 12 345 with thin spaces.
export function counted(n: number): string {
  return Math.round(n).toString().replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
}

/// Round values inside a range, at most `most` of them.
export function ticks(low: number, high: number, most: number): number[] {
  if (!(high > low)) return [low];
  const raw = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * power).find((s) => s >= raw * 0.999)!;
  const list: number[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) list.push(i * step);
  return list;
}
