/** Options in the address of the page, and which of them the form has a field for. */

import type { Capabilities, Options } from "./service/service";

export type Chosen = Partial<Options>;
export const UNITS: readonly NonNullable<Options["unit"]>[] = ["um", "mm", "cm", "m", "km", "inch", "ft", "us-ft"];

/** Those that an address holds; none where it holds nothing of the kind. */
export function ofLink(hash: string): Chosen {
  try {
    const told: unknown = JSON.parse(decodeURIComponent(hash.slice(1)));
    return isObject(told) ? (told as Chosen) : {};
  } catch {
    return {};
  }
}

export const toLink = (options: Chosen): string =>
  Object.keys(options).length ? `#${encodeURIComponent(JSON.stringify(options))}` : "#";

type Shows = (value: unknown, known: Capabilities) => boolean;
const SHOWN: Record<string, Shows> = {
  kinds: (value, { kinds }) => Array.isArray(value) && value.every((each) => (kinds as readonly unknown[]).includes(each)),
  criterion: (value, { criteria }) => (criteria as readonly unknown[]).includes(value),
  unit: (value) => (UNITS as readonly unknown[]).includes(value),
  tolerance: (value) => typeof value === "number",
  constraints: (value) => isObject(value) && Object.entries(value).every(([name, each]) => CONSTRAINTS[name]?.(each)),
};
const CONSTRAINTS: Record<string, (value: unknown) => boolean> = {
  radius: (value) => isObject(value) && Object.keys(value).join() === "value" && typeof value.value === "number",
  axis: (value) => isObject(value) && isDirection(value.direction) && value.max_angle === 0,
};

/** The options that fields of the form show. A link may hold anything else, too. */
export const fielded = (options: Chosen, known: Capabilities): Chosen =>
  Object.fromEntries(Object.entries(options).filter(([name, value]) => SHOWN[name]?.(value, known)));

const isObject = (value: unknown): value is Record<string, unknown> =>
  typeof value === "object" && value !== null && !Array.isArray(value);

const isDirection = (value: unknown): boolean =>
  Array.isArray(value) && value.length === 3 && value.every((each) => typeof each === "number");
