import { TURN, stepsOf, type Kind, type Patch } from "./kind";
import { around, turning } from "./revolved";
import { along } from "./vector";

export const torus: Kind<"torus"> = {
  distance({ center: [p, q, r], axis: [a, b, c], major_radius: major, minor_radius: minor }) {
    return (x, y, z) => {
      const [dx, dy, dz] = [x - p, y - q, z - r];
      const height = dx * a + dy * b + dz * c;
      const out = Math.hypot(dy * c - dz * b, dz * a - dx * c, dx * b - dy * a);
      return Math.hypot(out - major, height) - minor;
    };
  },

  surface({ center, axis, major_radius: major, minor_radius: minor }, extents): Patch {
    const a = axis;
    const { u, v, start, span } = turning(a, extents);
    const tube = [extents?.tube_start_angle ?? 0, extents?.tube_span ?? TURN];
    return {
      u: [start, start + span],
      v: [tube[0], tube[0] + tube[1]],
      steps: [stepsOf(span), Math.ceil(stepsOf(tube[1]) / 2)],
      at(angle, around) {
        const ring = major + minor * Math.cos(around);
        return along(
          center,
          [minor * Math.sin(around), a],
          [ring * Math.cos(angle), u],
          [ring * Math.sin(angle), v],
        );
      },
    };
  },

  unrolled({ center, axis, major_radius: major, minor_radius: minor }, extents) {
    const at = around(center, axis, turning(axis, extents));
    const middle = extents ? extents.tube_start_angle + extents.tube_span / 2 : 0;
    return {
      names: ["along the ring", "around the tube"],
      at(x, y, z) {
        const { angle, radius, height } = at(x, y, z);
        const around = Math.atan2(height, radius - major) - middle;
        return [angle * major, (around - TURN * Math.round(around / TURN)) * minor];
      },
    };
  },

  dimensions({ center, axis, major_radius: major, minor_radius: minor }, extents) {
    const { u } = turning(axis, extents);
    const tube = along(center, [major, u]);
    return [
      {
        name: "ring diameter",
        length: 2 * major,
        from: along(center, [-major, u]),
        to: along(center, [major, u]),
      },
      {
        name: "tube diameter",
        length: 2 * minor,
        from: along(tube, [-minor, axis]),
        to: along(tube, [minor, axis]),
      },
    ];
  },
};
