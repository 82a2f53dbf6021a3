/** Surfaces as triangles, and their rims as lines, in the frame of the cloud. */

import { BufferAttribute, BufferGeometry, ShapeUtils, Vector2 } from "three";
import type { Cloud } from "../cloud";
import type { Flat, Patch } from "../geometry/kind";
import type { Vector } from "../geometry/vector";

type Surface = Patch | Flat;
export type Framed = (point: Vector) => Vector;

/** From the coordinates of the file to those of the scene. */
export function framed(cloud: Cloud): Framed {
  const { middle, size } = cloud.frame;
  return (point) => point.map((each, k) => (each - middle[k]) / size) as unknown as Vector;
}

export function meshOf(surface: Surface, place: Framed): BufferGeometry {
  return "pieces" in surface ? flatMesh(surface, place) : patchMesh(surface, place);
}

function patchMesh({ u, v, steps: [m, n], at }: Patch, place: Framed): BufferGeometry {
  const corners: number[] = [];
  for (let j = 0; j <= n; j++) {
    for (let i = 0; i <= m; i++) {
      corners.push(...place(at(u[0] + ((u[1] - u[0]) * i) / m, v[0] + ((v[1] - v[0]) * j) / n)));
    }
  }
  const triangles: number[] = [];
  for (let j = 0; j < n; j++) {
    for (let i = 0; i < m; i++) {
      const a = j * (m + 1) + i;
      const b = a + m + 1;
      triangles.push(a, a + 1, b + 1, a, b + 1, b);
    }
  }
  return geometry(corners, triangles);
}

function flatMesh({ pieces, at }: Flat, place: Framed): BufferGeometry {
  const corners: number[] = [];
  const triangles: number[] = [];
  for (const rings of pieces) {
    const first = corners.length / 3;
    const [outer, ...holes] = rings.map((ring) => ring.map(([s, t]) => new Vector2(s, t)));
    for (const face of ShapeUtils.triangulateShape(outer, holes)) triangles.push(...face.map((i) => first + i));
    for (const { x, y } of [outer, ...holes].flat()) corners.push(...place(at(x, y)));
  }
  return geometry(corners, triangles);
}

function geometry(corners: number[], triangles: number[]): BufferGeometry {
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(Float32Array.from(corners), 3));
  made.setIndex(triangles);
  made.computeVertexNormals();
  return made;
}

/** Lines of the surface that help to see its form: its rims, and some between them. */
export function linesOf(surface: Surface, place: Framed): BufferGeometry {
  const ends: number[] = [];
  const line = (points: Vector[]): void => {
    for (let i = 1; i < points.length; i++) ends.push(...place(points[i - 1]), ...place(points[i]));
  };
  if ("pieces" in surface) {
    for (const ring of surface.pieces.flat()) line([...ring, ring[0]].map(([s, t]) => surface.at(s, t)));
  } else {
    const { u, v, steps, at } = surface;
    const between = ([low, high]: readonly [number, number], n: number): number[] =>
      Array.from({ length: n + 1 }, (_, i) => low + ((high - low) * i) / n);
    for (const fixed of between(v, 2)) line(between(u, steps[0]).map((each) => at(each, fixed)));
    for (const fixed of between(u, 6)) line(between(v, Math.max(steps[1], 1)).map((each) => at(fixed, each)));
  }
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(Float32Array.from(ends), 3));
  return made;
}
