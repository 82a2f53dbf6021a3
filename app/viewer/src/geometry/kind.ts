/** What the page has to know of a kind: one file for each beside this one, found through `kinds.ts`. */

import type { components } from "../schema";
import type { Cloud } from "../cloud";
import type { Vector } from "./vector";

type Schemas = components["schemas"];
export type Answer = Schemas["FitAnswer"];
export type Primitive = NonNullable<Answer["primitive"]>;
export type Extents = NonNullable<Answer["extents"]>;
export type Of<K extends Primitive["kind"]> = Extract<Primitive, { kind: K }>;
export type ExtentsOf<K extends Primitive["kind"]> = Extract<Extents, { kind: K }>;

/** A piece of surface over two parameters; each runs over [first, last] in so many steps. */
export interface Patch {
  readonly u: readonly [number, number];
  readonly v: readonly [number, number];
  readonly steps: readonly [number, number];
  at(u: number, v: number): Vector;
}

/** A piece of a plane: rings of corners, the outer one first, in coordinates along two directions of it. */
export interface Flat {
  readonly pieces: readonly (readonly (readonly [number, number])[])[][];
  at(u: number, v: number): Vector;
}

/** A surface rolled out: where a point lies on it, and what the two directions are. */
export interface Unrolled {
  readonly names: readonly [string, string];
  at(x: number, y: number, z: number): readonly [number, number];
}

/** A length drawn in the scene, between two points. */
export interface Dimension {
  readonly name: string;
  readonly length: number;
  readonly from: Vector;
  readonly to: Vector;
}

export interface Kind<K extends Primitive["kind"]> {
  /** Signed orthogonal distance of a point, as the service computes it. */
  distance(primitive: Of<K>): (x: number, y: number, z: number) => number;
  /** The piece that the extents describe; where there are none, the piece about the points. */
  surface(primitive: Of<K>, extents: ExtentsOf<K> | null, cloud: Cloud): Patch | Flat;
  unrolled(primitive: Of<K>, extents: ExtentsOf<K> | null): Unrolled | null;
  dimensions(primitive: Of<K>, extents: ExtentsOf<K> | null): Dimension[];
}

export const TURN = 2 * Math.PI;
/** Steps of a full turn. */
export const FINE = 96;

export const stepsOf = (span: number): number => Math.max(2, Math.ceil((FINE * Math.abs(span)) / TURN));
