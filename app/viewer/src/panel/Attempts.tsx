/** Every kind that was tried, in its order: a step to look at. */

import type { Answer } from "../geometry/kind";
import { plain } from "../numbers";
import * as state from "../state";

export function Attempts() {
  const attempts = state.answer.value?.attempts;
  if (!attempts?.length) return null;
  return (
    <section aria-labelledby="attempts">
      <h2 id="attempts">What was tried</h2>
      <ol class="attempts">
        {attempts.map((each, i) => (
          <li key={i}>
            <Attempt attempt={each} pressed={i === state.step.value} toggle={() => toggle(i)} />
          </li>
        ))}
      </ol>
    </section>
  );
}

const toggle = (i: number): void => {
  state.step.value = state.step.value === i ? null : i;
};

interface Props {
  attempt: Answer["attempts"][number];
  pressed: boolean;
  toggle: () => void;
}

function Attempt({ attempt, pressed, toggle }: Props) {
  const { kind, probability, outcome, reason, evidence, primitive } = attempt;
  return (
    <button type="button" aria-pressed={pressed} disabled={!primitive} onClick={toggle}>
      <span class={`outcome ${outcome}`}>
        <strong>{kind}</strong> {outcome.replace(/_/g, " ")}
      </span>
      <span class="reason">{reason}</span>
      <span class="small">
        {probability !== null && `expected with ${plain(100 * probability, 3)}%`}
        {evidence !== null && ` · evidence ${plain(evidence, 4)}`}
      </span>
    </button>
  );
}
