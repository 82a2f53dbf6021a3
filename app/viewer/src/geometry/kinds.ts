/** The kinds by their names: the only place where one is chosen. */

import type { Cloud } from "../cloud";
import { cone } from "./cone";
import { cylinder } from "./cylinder";
import type { Dimension, Extents, Flat, Kind, Patch, Primitive, Unrolled } from "./kind";
import { plane } from "./plane";
import { sphere } from "./sphere";
import { torus } from "./torus";

const KINDS: { [K in Primitive["kind"]]: Kind<K> } = { plane, sphere, cylinder, cone, torus };

const of = (primitive: Primitive): Kind<any> => KINDS[primitive.kind];

export const distanceTo = (primitive: Primitive): ((x: number, y: number, z: number) => number) =>
  of(primitive).distance(primitive);

export const surfaceOf = (primitive: Primitive, extents: Extents | null, cloud: Cloud): Patch | Flat =>
  of(primitive).surface(primitive, extents, cloud);

export const unrolledOf = (primitive: Primitive, extents: Extents | null): Unrolled | null =>
  of(primitive).unrolled(primitive, extents);

export const dimensionsOf = (primitive: Primitive, extents: Extents | null): Dimension[] =>
  of(primitive).dimensions(primitive, extents);
