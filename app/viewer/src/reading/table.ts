/** Columns of numbers or words, and which of them are coordinates and labels: a first look only.
 *
 * What the service reads counts, and is shown once it has answered; it also refuses what can be read in two ways.
 */

import { Cloud, type Labels } from "../cloud";

const LABELS = new Set([
  "label",
  "labels",
  "segment",
  "segment_id",
  "segments",
  "instance",
  "instance_id",
  "instances",
]);

/** A name without its unit: `X [mm]` is `x`. */
const bare = (name: string): string =>
  name
    .trim()
    .replace(/^["']|["']$/g, "")
    .replace(/\s*[[(].*$/, "")
    .toLowerCase();

export interface Columns {
  readonly xyz: readonly [number, number, number];
  readonly label: number | null;
}

export function columnsOf(names: readonly string[]): Columns | null {
  const plain = names.map(bare);
  const find = (axis: string): number =>
    plain.findIndex((name) => name === axis || name === `point_${axis}` || name === `coord_${axis}`);
  const xyz = [find("x"), find("y"), find("z")] as const;
  if (xyz.some((column) => column < 0)) return null;
  const label = plain.findIndex((name) => LABELS.has(name));
  return { xyz: [...xyz], label: label < 0 ? null : label };
}

/** Labels of points, numbered in the order in which they first come. */
export class Labelling {
  private readonly places = new Map<string | number, number>();
  private readonly of: number[] = [];

  add(label: string | number): void {
    let place = this.places.get(label);
    if (place === undefined) this.places.set(label, (place = this.places.size));
    this.of.push(place);
  }

  finished(): Labels {
    return { of: Int32Array.from(this.of), names: [...this.places.keys()] };
  }
}

/** A cloud of the rows whose coordinates are numbers; the others are taken out of the array that is given. */
export function cloudOf(xyz: Float64Array, labels: Labels | null): Cloud {
  let n = 0;
  const of = labels?.of.slice();
  for (let i = 0; i < xyz.length / 3; i++) {
    const [x, y, z] = [xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]];
    if (!Number.isFinite(x + y + z)) continue;
    xyz[3 * n] = x;
    xyz[3 * n + 1] = y;
    xyz[3 * n + 2] = z;
    if (of) of[n] = of[i];
    n++;
  }
  return new Cloud(xyz.subarray(0, 3 * n), of ? { of: of.slice(0, n), names: labels!.names } : null);
}
