/** The residuals as a histogram, and on the surface rolled out. */

import { useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { unrolledOf } from "../geometry/kinds";
import { plain } from "../numbers";
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
  return (
    <section aria-labelledby="residuals">
      <h2 id="residuals">Residuals</h2>
      <label>
        Color by{" "}
        <select
          value={state.coloring.value}
          onChange={(event) => (state.coloring.value = event.currentTarget.value as Coloring)}
        >
          {COLORINGS.filter(([name]) => (name !== "label" && name !== "kind") || state.isScan.value).map(([name, words]) => (
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

/** Points on the unrolled surface; one that is clicked is picked in the picture, too. */
function Unrolled() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const places = useRef<Float64Array>(new Float64Array());
  const [at, points] = [state.shown.value, state.cloud.value];
  useSignalEffect(() => {
    const [shown, cloud, values] = [state.shown.value, state.cloud.value, state.residuals.value];
    const surface = shown && unrolledOf(shown.primitive, shown.extents);
    if (canvas.current && surface && cloud && values) {
      places.current = draw(canvas.current, cloud.n, (i) => surface.at(...coordinates(cloud.xyz, i)), values);
    }
  });
  if (!at || !points) return null;
  const [across, up] = unrolledOf(at.primitive, at.extents)!.names;
  return (
    <figure>
      <canvas
        ref={canvas}
        class="map"
        width={640}
        height={360}
        role="img"
        aria-label={`The ${at.primitive.kind} rolled out, its points colored by residual.`}
        onClick={(event) => (picked.value = closest(places.current, event))}
      />
      <figcaption>
        {across} →, {up} ↑
      </figcaption>
    </figure>
  );
}

const coordinates = (xyz: Float64Array, i: number): [number, number, number] => [
  xyz[3 * i],
  xyz[3 * i + 1],
  xyz[3 * i + 2],
];

/** Draws the points; returns where they lie, in pixels (2 N). */
function draw(
  canvas: HTMLCanvasElement,
  n: number,
  at: (i: number) => readonly [number, number],
  values: Float64Array,
): Float64Array {
  const { width, height } = canvas;
  const places = new Float64Array(2 * n);
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
  const scale = [0, 1].map((k) => ([width, height][k] - 12) / (high[k] - low[k] || 1));
  const context = canvas.getContext("2d")!;
  context.clearRect(0, 0, width, height);
  const [limit, inlying] = [state.limit.value || 1, state.inliers.value];
  for (let i = 0; i < n; i++) {
    if (values[i] !== values[i]) continue;
    const x = (places[2 * i] = 6 + (places[2 * i] - low[0]) * scale[0]);
    const y = (places[2 * i + 1] = height - 6 - (places[2 * i + 1] - low[1]) * scale[1]);
    context.fillStyle = context.strokeStyle = css(ramped(values[i] / limit));
    if (inlying && !inlying[i]) context.strokeRect(x - 2, y - 2, 4, 4);
    else context.fillRect(x - 1.5, y - 1.5, 3, 3);
  }
  const chosen = picked.value;
  if (chosen !== null) {
    context.strokeStyle = "#ffffff";
    context.lineWidth = 2;
    context.strokeRect(places[2 * chosen] - 6, places[2 * chosen + 1] - 6, 12, 12);
    context.lineWidth = 1;
  }
  return places;
}

function closest(places: Float64Array, event: MouseEvent): number | null {
  const canvas = event.currentTarget as HTMLCanvasElement;
  const x = (event.offsetX * canvas.width) / canvas.clientWidth;
  const y = (event.offsetY * canvas.height) / canvas.clientHeight;
  let [best, found]: [number, number | null] = [15 ** 2, null];
  for (let i = 0; i < places.length / 2; i++) {
    const away = (places[2 * i] - x) ** 2 + (places[2 * i + 1] - y) ** 2;
    if (away < best) [best, found] = [away, i];
  }
  return found;
}
