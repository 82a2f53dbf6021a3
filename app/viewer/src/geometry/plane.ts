import type { Flat, Kind } from "./kind";
import { across, along, cross, dot, minus, type Vector } from "./vector";

export const plane: Kind<"plane"> = {
  distance({ normal: [a, b, c], point: [p, q, r] }) {
    return (x, y, z) => a * (x - p) + b * (y - q) + c * (z - r);
  },

  surface({ normal, point }, extents, cloud): Flat {
    const [u, v] = across(normal);
    const at = (s: number, t: number): Vector => along(point, [s, u], [t, v]);
    const flat = (corner: Vector): [number, number] => {
      const d = minus(corner, point);
      return [dot(d, u), dot(d, v)];
    };
    if (extents !== null) {
      return { pieces: extents.concave_outline.map((rings) => rings.map((ring) => ring.map(flat))), at };
    }
    const [s, t] = [cloud.range((x, y, z) => flat([x, y, z])[0]), cloud.range((x, y, z) => flat([x, y, z])[1])];
    return { pieces: [[[[s[0], t[0]], [s[1], t[0]], [s[1], t[1]], [s[0], t[1]]]]], at };
  },

  unrolled({ normal, point }, extents) {
    const u = (extents?.length_direction ?? across(normal)[0]);
    const v = cross(normal, u);
    return {
      names: ["along the length", "along the width"],
      at(x, y, z) {
        const d = minus([x, y, z], point);
        return [dot(d, u), dot(d, v)];
      },
    };
  },

  dimensions({ normal }, extents) {
    if (extents === null) return [];
    const u = extents.length_direction;
    const v = cross(normal, u);
    const [a, b] = [extents.length / 2, extents.width / 2];
    const corner = (s: number, t: number): Vector => along(extents.center, [s * a, u], [t * b, v]);
    return [
      { name: "length", length: extents.length, from: corner(-1, -1), to: corner(1, -1) },
      { name: "width", length: extents.width, from: corner(1, -1), to: corner(1, 1) },
    ];
  },
};
