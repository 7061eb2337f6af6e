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

/// Of ticks, with as few digits as say where they are, four at least.
export function namesOf(places: number[]): string[] {
  const step = places.length > 1 ? places[1]! - places[0]! : 0;
  let digits = 4;
  while (step > 0 && digits < 8 && places.some((x) => Math.abs(Number(x.toPrecision(digits)) - x) >= 0.02 * step)) ++digits;
  return places.map((x) => short(x, digits));
}

/// For the address and commands: as many digits as a float32 has, `inf` for infinity.
export function exact(x: number): string {
  if (!Number.isFinite(x)) return x > 0 ? "inf" : "-inf";
  return String(Number(x.toPrecision(9)));
}

/// The shortest decimal that is nearest to this float32 of all.
export function shortest32(x: number): string {
  const f = Math.fround(x);
  for (let digits = 1; digits < 9; ++digits) if (Math.fround(Number(f.toPrecision(digits))) === f) return String(Number(f.toPrecision(digits)));
  return String(Number(f.toPrecision(9)));
}

/// The largest float32 that is not above x: what lengths of the page are (FORMAT.md, "The sets").
export function floor32(x: number): number {
  const f = Math.fround(x);
  if (f <= x || !Number.isFinite(f)) return f;
  const bits = new Uint32Array(1), value = new Float32Array(bits.buffer);
  value[0] = f;
  bits[0] = f > 0 ? bits[0]! - 1 : f < 0 ? bits[0]! + 1 : 0x80000001;
  return value[0]!;
}

/// The shortest decimal that a comparison with levels (rounded down to float32) cannot tell from the float32 `x`; with
/// all digits where a level is `x` itself.
export function decimalOf(x: number, isLevel: boolean): string {
  if (!Number.isFinite(x)) return x > 0 ? "inf" : "-inf";
  if (!isLevel)
    for (let digits = 1; digits <= 9; ++digits) {
      const short = Number(x.toPrecision(digits));
      if (floor32(short) === x) return String(short);
    }
  return String(x);
}

export function parseLength(text: string): number {
  const word = text.trim().toLowerCase();
  if (word === "inf" || word === "infinity" || word === "∞") return Infinity;
  return word === "" ? NaN : Number(word.replace("−", "-"));
}

export const withUnit = (text: string, unit: string): string => (unit ? `${text}${unit === "°" ? "" : " "}${unit}` : text);

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
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) list.push(i * step + 0); // no negative zero
  return list;
}
