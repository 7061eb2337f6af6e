// SPDX-License-Identifier: Apache-2.0
// Logarithmic scale of a slider, and how much of a result lies where on it.

/// Positions 0 .. 1 for lengths from `floor` to `top`; what lies above (infinity) has the position 1. A floor of zero
/// has the position 0 and the logarithm begins at `smallest`.
export class LogScale {
  readonly begin: number;
  /// The end of the logarithmic part; from there to 1 is infinity.
  static readonly END = 0.94;
  constructor(readonly floor: number, readonly top: number, smallest: number) {
    this.begin = Math.max(floor, smallest);
    if (!(this.top > this.begin)) this.top = this.begin * 10;
  }
  position(x: number): number {
    if (x > this.top) return 1;
    if (!(x > this.begin)) return 0;
    return (Math.log(x / this.begin) / Math.log(this.top / this.begin)) * LogScale.END;
  }
  value(position: number, infinite: boolean): number {
    if (position <= 0) return this.floor;
    if (position > LogScale.END) return infinite && position > (1 + LogScale.END) / 2 ? Infinity : this.top;
    return this.begin * (this.top / this.begin) ** (position / LogScale.END);
  }
}

export function histogram(scale: LogScale, values: ArrayLike<number>, weight: (i: number) => number, bins: number): Float64Array {
  const result = new Float64Array(bins);
  for (let i = 0; i < values.length; ++i) {
    const x = values[i]!;
    if (Number.isNaN(x)) continue;
    const p = scale.position(x);
    result[Math.min(bins - 1, Math.floor(p * bins))]! += weight(i);
  }
  return result;
}
