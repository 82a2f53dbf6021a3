// The generated types on a client of a few lines: all there is between a program and the service.
import createClient from "openapi-fetch";
import type { components, paths } from "./schema.js";

export type Options = components["schemas"]["FitOptions"];
export type BatchLine = components["schemas"]["BatchLine"];
export type Primitive = NonNullable<components["schemas"]["FitAnswer"]["primitive"]>;

export const connect = (baseUrl: string) => createClient<paths>({ baseUrl });

/** The form of an upload: files as they are, options as JSON. */
export function form(parts: object): FormData {
  const data = new FormData();
  for (const [name, value] of Object.entries(parts)) {
    for (const part of Array.isArray(value) ? value : [value]) {
      data.append(name, part instanceof Blob ? part : new Blob([JSON.stringify(part)], { type: "application/json" }));
    }
  }
  return data;
}

/** One line about a primitive; the compiler knows the parameters of each kind. */
export function describe(primitive: Primitive): string {
  switch (primitive.kind) {
    case "plane":
      return `plane with normal ${primitive.normal}`;
    case "sphere":
      return `sphere of radius ${primitive.radius}`;
    case "cylinder":
      return `cylinder of radius ${primitive.radius}`;
    case "cone":
      return `cone of half-angle ${primitive.half_angle}`;
    case "torus":
      return `torus of radii ${primitive.major_radius} and ${primitive.minor_radius}`;
  }
}
