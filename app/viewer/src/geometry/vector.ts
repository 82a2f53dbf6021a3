/** Vectors of three numbers, and frames of three of them. */

export type Vector = readonly [number, number, number];

export const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

export const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

/** a + s b, and so on for further pairs. */
export function along(a: Vector, ...steps: [number, Vector][]): Vector {
  const sum: [number, number, number] = [...a];
  for (const [s, b] of steps) for (let i = 0; i < 3; i++) sum[i] += s * b[i];
  return sum;
}

export function unit(a: Vector): Vector {
  const length = Math.hypot(...a);
  return [a[0] / length, a[1] / length, a[2] / length];
}

/** Two unit vectors u, v that complete a unit vector to a right-handed frame: u x v is it. */
export function across(axis: Vector): [Vector, Vector] {
  const least = axis.map(Math.abs).indexOf(Math.min(...axis.map(Math.abs)));
  const u = unit(cross(axis, [Number(least === 0), Number(least === 1), Number(least === 2)]));
  return [u, cross(axis, u)];
}
