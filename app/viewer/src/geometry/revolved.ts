/** What cylinder, cone and torus share: an axis, and an arc about it. */

import { across, cross, dot, minus, type Vector } from "./vector";
import { TURN } from "./kind";

interface Arc {
  readonly reference_direction: Vector;
  readonly start_angle: number;
  readonly span: number;
  readonly full_turn: boolean;
}

export interface Turning {
  readonly u: Vector;
  readonly v: Vector;
  readonly start: number;
  readonly span: number;
}

/** The two directions that angles are measured by, and the arc; a full turn where none is known. */
export function turning(axis: Vector, arc: Arc | null): Turning {
  if (arc === null) {
    const [u, v] = across(axis);
    return { u, v, start: 0, span: TURN };
  }
  const u = arc.reference_direction;
  return { u, v: cross(axis, u), start: arc.start_angle, span: arc.span };
}

/** Angle about the axis from the middle of the arc, so that the arc is not cut, and height along the axis. */
export function around(
  origin: Vector,
  axis: Vector,
  { u, v, start, span }: Turning,
): (x: number, y: number, z: number) => { angle: number; radius: number; height: number } {
  const middle = start + span / 2;
  return (x, y, z) => {
    const d = minus([x, y, z], origin);
    const a = dot(d, u);
    const b = dot(d, v);
    const angle = Math.atan2(b, a) - middle;
    return {
      angle: angle - TURN * Math.round(angle / TURN),
      radius: Math.hypot(a, b),
      height: dot(d, axis),
    };
  };
}
