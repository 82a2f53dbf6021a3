/** Clouds to begin with, made here: what a scanner sees of a surface, with normally distributed noise. */

import { along, type Vector } from "./geometry/vector";

interface Example {
  readonly name: string;
  file(): Blob;
}

const N = 1500;
const TURN = 2 * Math.PI;

/** Numbers in [0, 1) that are the same each time. */
function numbers(seed: number): () => number {
  return () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 2 ** 32;
  };
}

type Surface = (a: number, b: number) => { at: Vector; normal: Vector };

const made = (name: string, noise: number, stray: number, surface: Surface): Example => ({
  name,
  file() {
    const next = numbers(name.length);
    const normal = (): number => Math.sqrt(-2 * Math.log(1 - next())) * Math.cos(TURN * next());
    const rows = Array.from({ length: N }, () => {
      const { at, normal: out } = surface(next(), next());
      const far = next() < stray ? 40 * (next() - 0.5) : 0;
      return along(at, [noise * normal() + far, out]).map((each) => each.toFixed(4)).join(" ");
    });
    return new Blob([`# x y z\n${rows.join("\n")}\n`]);
  },
});

const ring = (angle: number): Vector => [Math.cos(angle), Math.sin(angle), 0];
const tilted = ([x, y, z]: Vector): Vector => [0.8 * x + 0.6 * z, y, 0.8 * z - 0.6 * x];

export const EXAMPLES: readonly Example[] = [
  made("pipe", 0.15, 0.04, (a, b) => {
    const out = tilted(ring(0.3 + 0.55 * TURN * a));
    return { at: along(tilted([0, 0, 160 * b]), [30, out]), normal: out };
  }),
  made("ball", 0.1, 0.02, (a, b) => {
    const z = 1 - 1.2 * b;
    const out: Vector = along([0, 0, z], [Math.sqrt(1 - z * z), ring(TURN * a)]);
    return { at: along([100, 50, 20], [25, out]), normal: out };
  }),
  made("plate", 0.2, 0.03, (a, b) => ({
    at: tilted([200 * a, 120 * b, 0]),
    normal: tilted([0, 0, 1]),
  })),
  made("nozzle", 0.1, 0.02, (a, b) => {
    const [angle, height] = [TURN * a, Math.sqrt(900 + b * (10_000 - 900))];
    const out = along([0, 0, -Math.sin(0.3)], [Math.cos(0.3), ring(angle)]);
    return { at: along([0, 0, height], [height * Math.tan(0.3), ring(angle)]), normal: out };
  }),
  made("elbow", 0.1, 0.03, (a, b) => {
    const [angle, tube] = [0.25 * TURN * a, TURN * b];
    const out = along([0, 0, Math.sin(tube)], [Math.cos(tube), ring(angle)]);
    return { at: along([0, 0, 0], [80, ring(angle)], [20, out]), normal: out };
  }),
];
