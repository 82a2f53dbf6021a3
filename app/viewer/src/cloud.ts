/** Points as they were read: coordinates (3 N) in the unit of the file, and what stands beside them. */

export interface Labels {
  /** For each point its place in `names`. */
  readonly of: Int32Array;
  readonly names: readonly (string | number)[];
}

export class Cloud {
  readonly n: number;
  readonly low: readonly number[];
  readonly high: readonly number[];

  constructor(
    readonly xyz: Float64Array,
    readonly labels: Labels | null = null,
  ) {
    this.n = xyz.length / 3;
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < xyz.length; i += 3) {
      for (let k = 0; k < 3; k++) {
        const value = xyz[i + k];
        if (value < low[k]) low[k] = value;
        if (value > high[k]) high[k] = value;
      }
    }
    this.low = low;
    this.high = high;
  }

  /** Least and largest value of a function over the points. */
  range(value: (x: number, y: number, z: number) => number): [number, number] {
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < this.xyz.length; i += 3) {
      const each = value(this.xyz[i], this.xyz[i + 1], this.xyz[i + 2]);
      if (each < low) low = each;
      if (each > high) high = each;
    }
    return [low, high];
  }

  /** A function of each point (N). */
  map(value: (x: number, y: number, z: number) => number): Float64Array {
    const values = new Float64Array(this.n);
    for (let i = 0; i < this.n; i++) {
      values[i] = value(this.xyz[3 * i], this.xyz[3 * i + 1], this.xyz[3 * i + 2]);
    }
    return values;
  }

  /** Middle of the bounding box and half its diagonal. */
  get frame(): { middle: [number, number, number]; size: number } {
    const middle = this.low.map((low, k) => (low + this.high[k]) / 2) as [number, number, number];
    const size = Math.hypot(...this.low.map((low, k) => this.high[k] - low)) / 2;
    return { middle, size: size > 0 && Number.isFinite(size) ? size : 1 };
  }
}
