/** Colors of points. Signed values: ColorBrewer's RdBu without its dark ends, on a dark ground, blue is negative. */

export type Color = readonly [number, number, number];

const parsed = (hex: string): Color => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255) as never;

export const RAMP = "4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d".split(" ").map(parsed);

/** Okabe and Ito's colors, which people of any color vision tell apart; labels beyond them begin anew. */
export const LABELS = "56b4e9 e69f00 009e73 f0e442 cc79a7 d55e00 0072b2 bbbbbb".split(" ").map(parsed);

/** In the order of their colors. */
export const KINDS = ["plane", "sphere", "cylinder", "cone", "torus"] as const;

export const PLAIN = parsed("c8d2dc");

export const css = (color: Color): string => `rgb(${color.map((part) => Math.round(255 * part)).join(" ")})`;

/** Of a value in [-1, 1]; beyond it the ends. */
export function ramped(value: number): Color {
  const place = ((Math.min(1, Math.max(-1, value)) + 1) / 2) * (RAMP.length - 1);
  const i = Math.min(RAMP.length - 2, Math.floor(place));
  return RAMP[i].map((part, k) => part + (place - i) * (RAMP[i + 1][k] - part)) as never;
}
