/** The picture with what lies over it: lengths, the picked point, the outline, the legend. */

import { effect, signal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { dimensionsOf, surfaceOf } from "../geometry/kinds";
import type { Vector } from "../geometry/vector";
import { closeTo, least, plain } from "../numbers";
import { KINDS, LABELS } from "../scene/colors";
import { View } from "../scene/scene";
import type { Source } from "../service/service";
import * as state from "../state";
import { boxed, byArrow, chosen, measured, note, outline, picked, showBox, tool, within } from "../tools";

export const withSurface = signal(true);
export const withDimensions = signal(true);
export const view = signal<View | null>(null);

const TURN = 0.12;
/** The file whose points were last seen whole. */
let seen: Source | null = null;

export function Picture() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const tags = useRef<HTMLDivElement>(null);
  const spot = useRef<HTMLDivElement>(null);
  const placeAll = (): void => {
    if (!view.value) return;
    placeTags(view.value, tags.current!);
    placeSpot(view.value, spot.current!);
  };
  useEffect(() => {
    const made = new View(canvas.current!);
    view.value = made;
    made.onFrame = placeAll;
    const stops = [
      effect(() => {
        made.cloud(state.cloud.value);
        if (state.source.peek() !== seen) made.home();
        if (state.cloud.value) seen = state.source.peek();
      }),
      effect(() => made.look(look())),
      effect(() => made.show(surface())),
      effect(() => made.measures(lines().map(({ ends }) => ends))),
      effect(() => void (made.turns = !draws())),
    ];
    return () => stops.forEach((stop) => stop());
  }, []);
  useSignalEffect(() => {
    lines();
    picked.value;
    requestAnimationFrame(placeAll);
  });
  return (
    <div class="picture">
      <canvas
        ref={canvas}
        tabIndex={state.cloud.value ? 0 : -1}
        role="img"
        aria-label={described()}
        aria-describedby="facts"
        onKeyDown={byKeys}
        onPointerDown={(event) => start(event)}
        onPointerMove={(event) => move(event)}
        onPointerUp={(event) => end(event)}
        onPointerCancel={giveUp}
      />
      <div ref={tags} class="tags" aria-hidden="true">
        {lines().map(({ name, length }) => (
          <span key={name}>
            {name} {plain(length)} {state.unit.value}
          </span>
        ))}
      </div>
      <div ref={spot} class="spot" aria-hidden="true" hidden />
      {outline.value && (
        <svg class="outline" aria-hidden="true">
          <polygon points={outline.value.map((each) => each.join(",")).join(" ")} />
        </svg>
      )}
      <div class="aim" aria-hidden="true" />
    </div>
  );
}

const look = () => ({
  values: state.residuals.value,
  limit: state.limit.value,
  inliers: state.inliers.value,
  labels: colored(),
  chosen: chosen.value ?? state.members.value,
  coloring: state.residuals.value || byLabel() ? state.coloring.value : ("plain" as const),
});

const byLabel = (): boolean => state.coloring.value === "label" || state.coloring.value === "kind";

/** The number of the color of each point, by its label or by the kind of its segment. */
function colored(): Int32Array | null {
  const labels = state.preview.value?.labels;
  if (!labels || !byLabel()) return null;
  return state.coloring.value === "label" ? labels.of : labels.of.map((each) => kindOf(labels.names[each]));
}

/** The place of the kind that a segment is; beyond all of them while it is not fitted, or is none. */
function kindOf(label: string | number): number {
  const line = state.segments.value?.find((each) => each.label === label);
  const kind = line && "answer" in line && line.answer.status !== "no_fit" ? line.answer.primitive?.kind : undefined;
  return kind ? KINDS.indexOf(kind) : LABELS.length - 1;
}

function surface() {
  const [at, points] = [state.shown.value, state.cloud.value];
  return at && points && points.n > 0 && withSurface.value ? surfaceOf(at.primitive, at.extents, points) : null;
}

interface Length {
  readonly name: string;
  readonly length: number;
  readonly ends: readonly [Vector, Vector];
}

function lines(): Length[] {
  const at = state.shown.value;
  const own = at && withDimensions.value ? dimensionsOf(at.primitive, at.extents) : [];
  const shown: Length[] = own.map(({ name, length, from, to }) => ({ name, length, ends: [from, to] }));
  const [a, b] = measured.value;
  if (a && b) shown.push({ name: "measured", length: Math.hypot(...a.map((each, k) => each - b[k])), ends: [a, b] });
  return shown;
}

/** About as large is a tag [CSS pixels]. */
const [BROAD, HIGH] = [120, 22];

/** At three quarters of each line, where lines that cross in their middles lie apart; else below the others. */
function placeTags(made: View, tags: HTMLElement): void {
  const taken: (readonly [number, number])[] = [];
  lines().forEach(({ ends: [from, to] }, i) => {
    const [a, b] = [made.seen(from), made.seen(to)];
    const tag = tags.children[i] as HTMLElement | undefined;
    let [x, y] = [0, 1].map((k) => 0.25 * a[k] + 0.75 * b[k]);
    if (x < tags.clientWidth) x = Math.min(x, tags.clientWidth - BROAD);
    while (taken.some(([u, v]) => Math.abs(u - x) < BROAD && Math.abs(v - y) < HIGH)) y += HIGH;
    taken.push([x, y]);
    tag?.style.setProperty("transform", `translate(${x}px, ${y}px)`);
  });
}

function placeSpot(made: View, spot: HTMLElement): void {
  const at = picked.value;
  spot.hidden = at === null || !state.cloud.value;
  if (spot.hidden) return;
  const [x, y] = made.seen(placeOf(at!));
  spot.style.setProperty("transform", `translate(${x}px, ${y}px)`);
}

function described(): string {
  const [points, told] = [state.cloud.value, state.answer.value];
  if (!points) return "No points yet";
  const what = told?.primitive ? `, with a ${told.primitive.kind}` : "";
  return `${points.n} points${what}. ${KEYS[tool.value]}`;
}

const TURNING = "Arrow keys turn the view, with Shift they move it; plus and minus come closer and go away.";
const BOX = "Arrow keys move the box, with Shift they stretch it; Enter selects what is in it.";
const KEYS = {
  look: `${TURNING} Enter picks the point in the middle.`,
  measure: `${TURNING} Enter takes the point in the middle for an end.`,
  lasso: `${BOX} Escape ends it.`,
  box: `${BOX} Escape ends it.`,
};

/** Whether the hand draws around points. */
const draws = (): boolean => tool.value === "lasso" || tool.value === "box";

function byKeys(event: KeyboardEvent): void {
  const made = view.value;
  if (!made || event.ctrlKey || event.metaKey || event.altKey) return;
  if (draws() ? drawn(event, made) : turned(event, made)) event.preventDefault();
}

function turned(event: KeyboardEvent, made: View): boolean {
  const { clientWidth, clientHeight } = event.currentTarget as HTMLCanvasElement;
  const moves: Record<string, () => void> = {
    ArrowLeft: () => (event.shiftKey ? made.pan(-0.1, 0) : made.turn(-TURN, 0)),
    ArrowRight: () => (event.shiftKey ? made.pan(0.1, 0) : made.turn(TURN, 0)),
    ArrowUp: () => (event.shiftKey ? made.pan(0, -0.1) : made.turn(0, -TURN)),
    ArrowDown: () => (event.shiftKey ? made.pan(0, 0.1) : made.turn(0, TURN)),
    "+": () => made.dolly(0.8),
    "=": () => made.dolly(0.8),
    "-": () => made.dolly(1.25),
    Home: () => made.home(),
    Enter: () => take(made, [clientWidth / 2, clientHeight / 2]),
  };
  moves[event.key]?.();
  return event.key in moves;
}

/** By the keyboard both tools have a box. */
function drawn(event: KeyboardEvent, made: View): boolean {
  const { clientWidth, clientHeight } = event.currentTarget as HTMLCanvasElement;
  if (event.key === "Escape") {
    outline.value = null;
    tool.value = "look";
  } else if (event.key === "Enter") {
    if (outline.value) enclose(made);
    else showBox(clientWidth, clientHeight);
  } else {
    if (event.key.startsWith("Arrow") && !outline.value) showBox(clientWidth, clientHeight);
    return byArrow(event.key, event.shiftKey, clientWidth, clientHeight);
  }
  return true;
}

/** Select what lies within the outline. */
function enclose(made: View): void {
  const points = state.cloud.value;
  if (points && outline.value) within(made.seenAll(points), outline.value);
  outline.value = null;
}

let pressed: [number, number] | null = null;

const place = (event: PointerEvent): [number, number] => [event.offsetX, event.offsetY];

function start(event: PointerEvent): void {
  pressed = place(event);
  if (!draws()) return;
  (event.target as Element).setPointerCapture(event.pointerId);
  outline.value = [pressed];
}

function move(event: PointerEvent): void {
  if (!outline.value || !pressed) return;
  outline.value = tool.value === "box" ? boxed(pressed, place(event)) : [...outline.value, place(event)];
}

function end(event: PointerEvent): void {
  const [made, from, to] = [view.value, pressed, place(event)];
  pressed = null;
  if (!made || !from) return;
  if (outline.value) enclose(made);
  else if (Math.hypot(to[0] - from[0], to[1] - from[1]) < 4) take(made, to);
}

/** The screen took the gesture for its own. */
function giveUp(): void {
  outline.value = pressed = null;
}

/** So far from a point it is still meant, as by a finger [CSS pixels]. */
const REACH = 15;

function seenAt(made: View, [x, y]: readonly [number, number]): number | null {
  const points = state.cloud.value;
  return made.pick(x, y) ?? (points && least(made.seenAll(points), closeTo(x, y, REACH)));
}

/** Pick the point that is seen at a place, for one end of a length if one is measured. */
function take(made: View, at: readonly [number, number]): void {
  picked.value = seenAt(made, at);
  if (picked.value === null) note.value = "No point is there.";
  else if (tool.value === "measure") measure(placeOf(picked.value));
  else note.value = "";
}

function placeOf(point: number): Vector {
  return [...state.cloud.value!.xyz.subarray(3 * point, 3 * point + 3)] as unknown as Vector;
}

function measure(end: Vector): void {
  measured.value = measured.value.length === 1 ? [measured.value[0], end] : [end];
  note.value = measured.value.length === 1 ? "Choose the other end." : "";
}
