/** What the hand does in the picture: look, measure, or draw around points; the keyboard does the same. */

import { signal, effect } from "@preact/signals";
import type { Vector } from "./geometry/vector";
import { counted } from "./numbers";
import * as state from "./state";

export type Tool = "look" | "measure" | "lasso" | "box";
export const tool = signal<Tool>("look");
type Place = readonly [number, number];
/** Corners of what is drawn around points, in pixels of the picture. */
export const outline = signal<readonly Place[] | null>(null);
/** 1 for each selected point; null for no selection. */
export const chosen = signal<Uint8Array | null>(null);
export const picked = signal<number | null>(null);
export const measured = signal<readonly Vector[]>([]);

/** What to do with the tool, or what came of it. */
export const note = signal("");

const HINTS: Record<Tool, string> = {
  look: "",
  measure: "Choose two points.",
  lasso: "Draw around points.",
  box: "Draw a box around points.",
};

effect(() => {
  note.value = HINTS[tool.value];
  outline.value = null;
});

effect(() => {
  state.cloud.value;
  chosen.value = null;
  picked.value = null;
  measured.value = [];
});

/** Corners of a box, by two that lie across from each other. */
export const boxed = ([x, y]: Place, [u, v]: Place): Place[] => [[x, y], [u, y], [u, v], [x, v]];

/** The box that the keyboard moves and stretches, as shares of the picture. */
const MIDDLE = { x: 0.5, y: 0.5, width: 0.4, height: 0.4 };
let box = MIDDLE;

/** Begin with a box in the middle. */
export function showBox(width: number, height: number): void {
  box = MIDDLE;
  drawBox(width, height);
}

/** Move the box, or stretch it, by a step; false for keys that do neither. */
export function byArrow(key: string, stretch: boolean, width: number, height: number): boolean {
  const [right, down] = ARROWS[key] ?? [0, 0];
  if (!right && !down) return false;
  box = stretch
    ? { ...box, width: clamped(box.width + right * STEP), height: clamped(box.height + down * STEP) }
    : { ...box, x: clamped(box.x + right * STEP), y: clamped(box.y + down * STEP) };
  drawBox(width, height);
  return true;
}

const STEP = 0.02;
const ARROWS: Record<string, Place> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const clamped = (share: number): number => Math.min(1, Math.max(STEP, share));

function drawBox(width: number, height: number): void {
  const ends = [-1, 1].map((side): Place => [
    width * (box.x + (side * box.width) / 2),
    height * (box.y + (side * box.height) / 2),
  ]);
  outline.value = boxed(ends[0], ends[1]);
}

/** Select the points that are seen inside of a line. */
export function within(seen: Float64Array, line: readonly Place[]): void {
  const marks = new Uint8Array(seen.length / 2);
  let n = 0;
  for (let i = 0; i < marks.length; i++) {
    if (inside(seen[2 * i], seen[2 * i + 1], line)) {
      marks[i] = 1;
      n++;
    }
  }
  chosen.value = n ? marks : null;
  note.value = n ? `${counted(n, "point")} selected.` : "No point is selected.";
}

/** Whether a ray to the right crosses the line an odd number of times. */
function inside(x: number, y: number, line: readonly Place[]): boolean {
  let odd = false;
  line.forEach(([bx, by], i) => {
    const [ax, ay] = line[i ? i - 1 : line.length - 1];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) odd = !odd;
  });
  return odd;
}

/** Have the selected points fitted, as a file of their own. */
export async function fitChosen(): Promise<void> {
  const [points, marks, from] = [state.cloud.value, chosen.value, state.source.value];
  if (!points || !marks || !from) return;
  const rows: number[] = [];
  for (let i = 0; i < points.n; i++) if (marks[i]) rows.push(...points.xyz.subarray(3 * i, 3 * i + 3));
  tool.value = "look";
  const name = from.name.replace(/(\.[^.]*)?$/, "-selection.npy");
  await state.open(name, npy(Float64Array.from(rows)));
}

/** Coordinates (3 N) as a file of NumPy. */
function npy(xyz: Float64Array<ArrayBuffer>): Blob {
  const head = `{'descr': '<f8', 'fortran_order': False, 'shape': (${xyz.length / 3}, 3), }`;
  const padded = head.padEnd(Math.ceil((head.length + 11) / 64) * 64 - 11) + "\n";
  const start = new Uint8Array(10);
  start.set([0x93, ..."NUMPY".split("").map((each) => each.charCodeAt(0)), 1, 0]);
  new DataView(start.buffer).setUint16(8, padded.length, true);
  return new Blob([start, padded, xyz]);
}
