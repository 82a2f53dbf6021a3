/** The residuals as a histogram, and on the surface rolled out. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { unrolledOf } from "../geometry/kinds";
import { closeTo, least, plain } from "../numbers";
import { css, ramped } from "../scene/colors";
import type { Coloring } from "../scene/points";
import * as state from "../state";
import { picked } from "../tools";

const BINS = 41;
const COLORINGS: [Coloring, string][] = [
  ["residual", "residual"],
  ["inlier", "inlier or not"],
  ["label", "label"],
  ["kind", "kind"],
  ["plain", "none"],
];

export function Residuals() {
  if (!state.cloud.value) return null;
  const offered = known();
  if (offered.length === 1) return null;
  return (
    <section aria-labelledby="residuals">
      <h2 id="residuals">{state.residuals.value ? "Residuals" : "Colors"}</h2>
      <label>
        Color by{" "}
        <select
          value={offered.includes(state.coloring.value) ? state.coloring.value : "plain"}
          onChange={(event) => (state.coloring.value = event.currentTarget.value as Coloring)}
        >
          {COLORINGS.filter(([name]) => offered.includes(name)).map(([name, words]) => (
            <option key={name} value={name}>
              {words}
            </option>
          ))}
        </select>
      </label>
      {state.residuals.value && (
        <>
          <Histogram values={state.residuals.value} limit={state.limit.value} />
          <Unrolled />
        </>
      )}
    </section>
  );
}

/** What is known of the points to color them by. */
function known(): Coloring[] {
  const all: [Coloring, unknown][] = [
    ["residual", state.residuals.value],
    ["inlier", state.inliers.value],
    ["label", state.isScan.value],
    ["kind", state.isScan.value && state.segments.value?.length],
    ["plain", true],
  ];
  return all.filter(([, there]) => there).map(([name]) => name);
}

function Histogram({ values, limit }: { values: Float64Array; limit: number }) {
  const counts = new Array<number>(BINS).fill(0);
  let beyond = 0;
  let n = 0;
  for (const each of values) {
    if (each !== each) continue;
    n++;
    if (Math.abs(each) > limit || limit === 0) beyond++;
    else counts[Math.min(BINS - 1, Math.floor(((each / limit + 1) / 2) * BINS))]++;
  }
  const most = Math.max(...counts, 1);
  const words = `Histogram of ${n - beyond} residuals within ${plain(limit, 3)}; ${beyond} are beyond.`;
  return (
    <figure>
      <svg class="histogram" viewBox={`0 0 ${BINS} 16`} preserveAspectRatio="none" role="img" aria-label={words}>
        {counts.map((count, i) => (
          <rect
            key={i}
            x={i + 0.06}
            width={0.88}
            y={16 - (16 * count) / most}
            height={(16 * count) / most}
            fill={css(ramped((2 * i + 1) / BINS - 1))}
          />
        ))}
      </svg>
      <figcaption>{beyond > 0 ? `${beyond.toLocaleString("en")} points are beyond the scale` : "all points"}</figcaption>
    </figure>
  );
}

const [WIDTH, HEIGHT, RIM] = [640, 360, 6];

/** The map, and where the points lie on it, in pixels (2 N). */
interface Chart {
  readonly image: ImageData;
  readonly places: Float64Array;
}

/** Points on the unrolled surface; one that is clicked is picked in the picture, too. */
function Unrolled() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const chart = useSignal<Chart | null>(null);
  useSignalEffect(() => {
    chart.value = null;
    const make = charting();
    return make ? afterPaint(() => (chart.value ??= make())) : undefined;
  });
  useSignalEffect(() => {
    const context = canvas.current?.getContext("2d");
    if (!context || !chart.value) return;
    const { image, places } = chart.value;
    context.putImageData(image, 0, 0);
    const chosen = picked.value;
    if (chosen === null) return;
    context.strokeStyle = "#ffffff";
    context.lineWidth = 2;
    context.strokeRect(places[2 * chosen] - 6, places[2 * chosen + 1] - 6, 12, 12);
  });
  /** Who uses the map does not wait for it. */
  const now = (): Chart | null => (chart.value ??= charting()?.() ?? null);
  const [at, points] = [state.shown.value, state.cloud.value];
  if (!at || !points) return null;
  const [across, up] = unrolledOf(at.primitive, at.extents)!.names;
  return (
    <figure>
      <canvas
        ref={canvas}
        class="map"
        width={WIDTH}
        height={HEIGHT}
        role="img"
        aria-label={`The ${at.primitive.kind} rolled out, its points colored by residual. Arrow keys pick a point.`}
        tabIndex={0}
        onClick={(event) => {
          const made = now();
          if (made) picked.value = closest(made.places, event);
        }}
        onKeyDown={(event) => {
          const made = event.key in ARROWS ? now() : null;
          const next = made && neighbor(made.places, picked.value, event.key);
          if (next === null) return;
          picked.value = next;
          event.preventDefault();
        }}
      />
      <figcaption>
        {across} →, {up} ↑
      </figcaption>
    </figure>
  );
}

/** How the map of what is shown now is made; null where there is none. */
function charting(): (() => Chart) | null {
  const [shown, cloud, values] = [state.shown.value, state.cloud.value, state.residuals.value];
  const [limit, inlying] = [state.limit.value, state.inliers.value];
  const surface = shown && unrolledOf(shown.primitive, shown.extents);
  if (!surface || !cloud || !values) return null;
  return () => {
    const places = placed(cloud.n, (i) => surface.at(...coordinates(cloud.xyz, i)), values);
    return { places, image: painted(places, values, limit || 1, inlying) };
  };
}

/** Do something once what changed has been painted; what is returned takes it back. */
function afterPaint(task: () => void): () => void {
  let timer = 0;
  const frame = requestAnimationFrame(() => (timer = setTimeout(task)));
  return () => {
    cancelAnimationFrame(frame);
    clearTimeout(timer);
  };
}

const coordinates = (xyz: Float64Array, i: number): [number, number, number] => [
  xyz[3 * i],
  xyz[3 * i + 1],
  xyz[3 * i + 2],
];

/** Where the points lie on the map that holds them all; NaN for those without a residual. */
function placed(n: number, at: (i: number) => readonly [number, number], values: Float64Array): Float64Array {
  const places = new Float64Array(2 * n).fill(NaN);
  const [low, high] = [[Infinity, Infinity], [-Infinity, -Infinity]];
  for (let i = 0; i < n; i++) {
    if (values[i] !== values[i]) continue;
    const place = at(i);
    for (let k = 0; k < 2; k++) {
      places[2 * i + k] = place[k];
      low[k] = Math.min(low[k], place[k]);
      high[k] = Math.max(high[k], place[k]);
    }
  }
  const [across, up] = [0, 1].map((k) => ([WIDTH, HEIGHT][k] - 2 * RIM) / (high[k] - low[k] || 1));
  for (let i = 0; i < n; i++) {
    places[2 * i] = RIM + (places[2 * i] - low[0]) * across;
    places[2 * i + 1] = HEIGHT - RIM - (places[2 * i + 1] - low[1]) * up;
  }
  return places;
}

/** Points as squares, those that were left out as larger ones that are empty. */
function painted(places: Float64Array, values: Float64Array, limit: number, inlying: Uint8Array | null): ImageData {
  const image = new ImageData(WIDTH, HEIGHT);
  const pixels = new Uint32Array(image.data.buffer);
  for (let i = 0; i < values.length; i++) {
    if (values[i] !== values[i]) continue;
    const [x, y] = [Math.round(places[2 * i]), Math.round(places[2 * i + 1])];
    const color = SHADES[Math.round(127.5 * (Math.max(-1, Math.min(1, values[i] / limit)) + 1))];
    const size = inlying && !inlying[i] ? 2 : 1;
    for (let up = -size; up <= size; up++) {
      for (let across = -size; across <= size; across++) {
        if (size === 1 || Math.max(Math.abs(across), Math.abs(up)) === size) pixels[(y + up) * WIDTH + x + across] = color;
      }
    }
  }
  return image;
}

/** The colors between -1 and 1 as pixels: bytes red, green, blue, alpha. */
const SHADES = new Uint32Array(
  Uint8Array.from(
    Array.from({ length: 256 }, (_, i) => [...ramped(i / 127.5 - 1), 1].map((part) => Math.round(255 * part))).flat(),
  ).buffer,
);

function closest(places: Float64Array, event: MouseEvent): number | null {
  const canvas = event.currentTarget as HTMLCanvasElement;
  const x = (event.offsetX * canvas.width) / canvas.clientWidth;
  const y = (event.offsetY * canvas.height) / canvas.clientHeight;
  return least(places, closeTo(x, y, 15));
}

const ARROWS: Record<string, readonly [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/** The next point in the direction of an arrow, or the one in the middle to begin with; null for none. */
function neighbor(places: Float64Array, from: number | null, key: string): number | null {
  const [right, down] = ARROWS[key];
  if (from === null) return least(places, (u, v) => Math.hypot(u - WIDTH / 2, v - HEIGHT / 2));
  return least(places, (u, v) => {
    const [x, y] = [u - places[2 * from], v - places[2 * from + 1]];
    const [ahead, aside] = [x * right + y * down, Math.abs(x * down) + Math.abs(y * right)];
    return ahead > 0 && aside <= ahead ? ahead + aside : Infinity;
  });
}
