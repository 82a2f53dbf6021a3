/** Numbers as they are read: as many digits as their doubt leaves, and no more. */

/** With so many significant digits, without an exponent where that is short. */
export function plain(value: number, digits = 5): string {
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  if (size < -4 || size > 8) return minus(value.toExponential(digits - 1));
  return fixed(value, Math.max(0, digits - 1 - size));
}

/** A value with half the width of its interval: both end at the second digit of the doubt. */
export function doubted(value: number, half: number | null): string {
  if (half === null || !(half > 0) || !Number.isFinite(half)) return plain(value);
  const places = Math.max(0, 1 - Math.floor(Math.log10(half)));
  if (places > 12) return plain(value, 12);
  return `${fixed(value, places)} ± ${half.toFixed(places)}`;
}

/** Coordinates of a point in a cloud of this size: to a ten-millionth of it, wherever it lies. */
export const placed = (coordinates: readonly number[], size: number): string =>
  coordinates.map((each) => fixed(each, Math.min(100, Math.max(0, 7 - Math.ceil(Math.log10(size)))))).join("  ");

export const degrees = (angle: number): number => (angle * 180) / Math.PI;

export const counted = (n: number, one: string, many = `${one}s`): string =>
  `${n.toLocaleString("en")} ${n === 1 ? one : many}`;

/** With so many places; what rounds to zero has no sign. */
export const fixed = (value: number, places: number): string => minus(value.toFixed(places).replace(/^-(?=[0.]*$)/, ""));

const minus = (text: string): string => text.replace(/-/g, "\u2212");

/** The place of least cost among places in a plane (2 N), by its number; null where all cost infinitely much. */
export function least(places: Float64Array, cost: (x: number, y: number) => number): number | null {
  let [best, found]: [number, number | null] = [Infinity, null];
  for (let i = 0; i < places.length / 2; i++) {
    const each = cost(places[2 * i], places[2 * i + 1]);
    if (each < best) [best, found] = [each, i];
  }
  return found;
}

/** The distance from a place as a cost; infinite beyond a reach. */
export const closeTo = (x: number, y: number, reach: number) => (u: number, v: number): number => {
  const away = Math.hypot(u - x, v - y);
  return away < reach ? away : Infinity;
};
