import { stepsOf, type Kind, type Patch } from "./kind";
import { around, turning } from "./revolved";
import { along, dot, minus, type Vector } from "./vector";

export const cylinder: Kind<"cylinder"> = {
  distance({ point: [p, q, r], axis: [a, b, c], radius }) {
    return (x, y, z) => {
      const [dx, dy, dz] = [x - p, y - q, z - r];
      return Math.hypot(dy * c - dz * b, dz * a - dx * c, dx * b - dy * a) - radius;
    };
  },

  surface({ point, axis, radius }, extents, cloud): Patch {
    const a = axis;
    const { u, v, start, span } = turning(a, extents);
    const height = (end: Vector): number => dot(minus(end, point), a);
    return {
      u: [start, start + span],
      v: extents
        ? [height(extents.start), height(extents.end)]
        : cloud.range((x, y, z) => height([x, y, z])),
      steps: [stepsOf(span), 1],
      at: (angle, h) =>
        along(point, [h, a], [radius * Math.cos(angle), u], [radius * Math.sin(angle), v]),
    };
  },

  unrolled({ point, axis, radius }, extents) {
    const at = around(point, axis, turning(axis, extents));
    return {
      names: ["around", "along the axis"],
      at(x, y, z) {
        const { angle, height } = at(x, y, z);
        return [angle * radius, height];
      },
    };
  },

  dimensions({ point, axis, radius }, extents) {
    const { u } = turning(axis, extents);
    const middle = extents
      ? along(extents.start, [0.5 * extents.length, axis])
      : (point);
    const diameter = {
      name: "diameter",
      length: 2 * radius,
      from: along(middle, [-radius, u]),
      to: along(middle, [radius, u]),
    };
    if (extents === null) return [diameter];
    const { start, end, length } = extents;
    return [diameter, { name: "length", length, from: start, to: end }];
  },
};
