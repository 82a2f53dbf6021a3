import { TURN, stepsOf, type Kind, type Patch } from "./kind";
import { across, along, dot, minus, type Vector } from "./vector";

const UP: Vector = [0, 0, 1];

export const sphere: Kind<"sphere"> = {
  distance({ center: [a, b, c], radius }) {
    return (x, y, z) => Math.hypot(x - a, y - b, z - c) - radius;
  },

  surface({ center, radius }, extents): Patch {
    const axis = (extents?.axis ?? UP);
    const [u, v] = across(axis);
    const polar: [number, number] = [extents?.start_half_angle ?? 0, extents?.half_angle ?? Math.PI];
    return {
      u: [0, TURN],
      v: polar,
      steps: [stepsOf(TURN), stepsOf(polar[1] - polar[0])],
      at(angle, tilt) {
        const ring = radius * Math.sin(tilt);
        return along(
          center,
          [radius * Math.cos(tilt), axis],
          [ring * Math.cos(angle), u],
          [ring * Math.sin(angle), v],
        );
      },
    };
  },

  /** Flattened about the middle of the cap: distances from it along the surface are true. */
  unrolled({ center, radius }, extents) {
    const axis = (extents?.axis ?? UP);
    const [u, v] = across(axis);
    return {
      names: ["from the middle of the cap", "across"],
      at(x, y, z) {
        const d = minus([x, y, z], center);
        const [a, b] = [dot(d, u), dot(d, v)];
        const out = Math.hypot(a, b);
        const way = radius * Math.atan2(out, dot(d, axis));
        return out > 0 ? [(way * a) / out, (way * b) / out] : [0, 0];
      },
    };
  },

  dimensions({ center, radius }, extents) {
    const [u] = across((extents?.axis ?? UP));
    return [
      {
        name: "diameter",
        length: 2 * radius,
        from: along(center, [-radius, u]),
        to: along(center, [radius, u]),
      },
    ];
  },
};
