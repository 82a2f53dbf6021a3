import { stepsOf, type Kind, type Patch } from "./kind";
import { around, turning } from "./revolved";
import { along, dot, minus, type Vector } from "./vector";

export const cone: Kind<"cone"> = {
  /** From the nappe along the axis; from the apex where that is the closest point. */
  distance({ apex: [p, q, r], axis: [a, b, c], half_angle: angle }) {
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    return (x, y, z) => {
      const [dx, dy, dz] = [x - p, y - q, z - r];
      const height = dx * a + dy * b + dz * c;
      const out = Math.hypot(dy * c - dz * b, dz * a - dx * c, dx * b - dy * a);
      const slant = height * cos + out * sin;
      return slant > 0 ? out * cos - height * sin : Math.hypot(height, out);
    };
  },

  surface({ apex, axis, half_angle }, extents, cloud): Patch {
    const a = axis;
    const { u, v, start, span } = turning(a, extents);
    const tangent = Math.tan(half_angle);
    const heights: readonly [number, number] = extents
      ? [extents.start_height, extents.end_height]
      : cloud.range((x, y, z) => Math.max(0, dot(minus([x, y, z], apex), a)));
    return {
      u: [start, start + span],
      v: heights,
      steps: [stepsOf(span), 8],
      at: (angle, h) =>
        along(
          apex,
          [h, a],
          [h * tangent * Math.cos(angle), u],
          [h * tangent * Math.sin(angle), v],
        ),
    };
  },

  unrolled({ apex, axis }, extents) {
    const at = around(apex, axis, turning(axis, extents));
    return {
      names: ["around the axis [°]", "height from the apex"],
      at(x, y, z) {
        const { angle, height } = at(x, y, z);
        return [(angle * 180) / Math.PI, height];
      },
    };
  },

  dimensions({ axis }, extents) {
    if (extents === null) return [];
    const { u } = turning(axis, extents);
    const across = (middle: Vector, radius: number, name: string) => ({
      name,
      length: 2 * radius,
      from: along(middle, [-radius, u]),
      to: along(middle, [radius, u]),
    });
    const { start, end, start_radius, end_radius, start_height, end_height } = extents;
    return [
      { name: "height", length: end_height - start_height, from: start, to: end },
      across(end, end_radius, "end diameter"),
      ...(start_radius > 0 ? [across(start, start_radius, "start diameter")] : []),
    ];
  },
};
