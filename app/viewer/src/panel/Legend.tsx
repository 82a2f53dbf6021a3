/** What the colors mean. The end of the scale can be dragged, and set by the keyboard. */

import { KINDS, LABELS, RAMP, css } from "../scene/colors";
import { plain } from "../numbers";
import * as state from "../state";

export function Legend() {
  if (state.coloring.value === "kind" && state.segments.value?.length) return <Kinds />;
  if (!state.residuals.value || state.coloring.value === "label" || state.coloring.value === "plain") return null;
  if (state.coloring.value === "inlier") {
    return (
      <div class="legend">
        <span class="key inlier">● inliers</span> <span class="key outlier">○ left out</span>
      </div>
    );
  }
  const limit = state.limit.value;
  const tolerance = state.answer.value?.receipt.options.tolerance ?? null;
  const share = tolerance && limit > 0 ? Math.min(1, tolerance / limit) : null;
  return (
    <div class="legend">
      <div class="title">
        residual from the {state.shown.value!.primitive.kind}
        {state.unit.value && ` [${state.unit.value}]`}{" "}
        {state.inliers.value && <span class="key">○ left out</span>}
      </div>
      <div class="bar" style={{ background: `linear-gradient(90deg, ${RAMP.map(css).join(", ")})` }}>
        {share !== null && (
          <div class="band" style={{ left: `${50 - 50 * share}%`, width: `${100 * share}%` }} title="tolerance" />
        )}
      </div>
      <div class="ticks">
        <span>{plain(-limit, 3)}</span>
        <span>0</span>
        <span>{plain(limit, 3)}</span>
      </div>
      <label class="range">
        colors end at
        <input
          type="range"
          min="-2"
          max="2"
          step="0.02"
          value={Math.log10(limit / base())}
          aria-valuetext={`${plain(limit, 3)} ${state.unit.value}`}
          onInput={(event) => (state.chosenLimit.value = base() * 10 ** Number(event.currentTarget.value))}
        />
      </label>
    </div>
  );
}

function Kinds() {
  return (
    <div class="legend">
      {KINDS.map((kind, i) => (
        <span class="key" key={kind}>
          <i style={{ background: css(LABELS[i]) }} /> {kind}
        </span>
      ))}
      <span class="key">
        <i style={{ background: css(LABELS[LABELS.length - 1]) }} /> none
      </span>
    </div>
  );
}

let fixed = 1;
/** The end that was there before somebody moved it: the middle of the slider. */
function base(): number {
  if (state.chosenLimit.value === null) fixed = state.limit.value || 1;
  return fixed;
}
