/** The segments of a scan, what each of them is, and how well: a list to choose from. */

import { counted, plain } from "../numbers";
import { KINDS, LABELS, css } from "../scene/colors";
import type { Line } from "../service/service";
import * as state from "../state";
import { chosen as selected, fitChosen } from "../tools";

export function Segments() {
  const lines = state.segments.value;
  if (lines === null || (!lines.length && state.cloud.value)) return null;
  const chosen = state.segment.value === null ? null : lines[state.segment.value];
  return (
    <section aria-labelledby="segments">
      <h2 id="segments">Segments</h2>
      <p>{summed(lines)}</p>
      {!state.cloud.value && <p>Open the file of this scan to see its points.</p>}
      <div class="scroll">
        <ul class="segments">
          {lines.map((line, i) => (
            <li key={line.id}>
              <button type="button" aria-pressed={i === state.segment.value} onClick={() => look(i)}>
                <i style={{ background: css(colorOf(line)) }} aria-hidden="true" />
                <strong>{String(line.label ?? line.id)}</strong>
                <span>{described(line)}</span>
              </button>
            </li>
          ))}
        </ul>
      </div>
      {chosen && "problem" in chosen && <p class="warning">{chosen.problem.detail}</p>}
      {state.members.value && (
        <button type="button" onClick={() => void alone()}>
          Open this segment alone
        </button>
      )}
    </section>
  );
}

function look(i: number): void {
  state.step.value = state.chosenLimit.value = null;
  state.segment.value = state.segment.value === i ? null : i;
  state.coloring.value = state.segment.value === null ? "kind" : "residual";
}

async function alone(): Promise<void> {
  selected.value = state.members.value;
  await fitChosen();
}

/** As the points of the segment are colored: by its label, or by its kind. */
function colorOf(line: Line) {
  const names = state.preview.value?.labels?.names;
  if (state.coloring.value === "label" && names) return LABELS[names.indexOf(line.label!) % LABELS.length];
  const kind = "answer" in line && line.answer.status !== "no_fit" ? line.answer.primitive?.kind : undefined;
  return LABELS[kind ? KINDS.indexOf(kind) : LABELS.length - 1];
}

function described(line: Line): string {
  if ("problem" in line) return line.problem.title;
  const { status, primitive, error, receipt } = line.answer;
  const kind = primitive?.kind ?? "nothing";
  const what = status === "no_fit" ? "no fit" : status === "ambiguous" ? `${kind}?` : kind;
  return `${what}${error ? `, rms ${plain(error.inlier_rms, 3)} ${receipt.unit ?? ""}` : ""}`;
}

const MANY: Record<string, string> = { torus: "tori", "no fit": "no fit", refused: "refused" };

function summed(lines: readonly Line[]): string {
  const counts = new Map<string, number>();
  for (const line of lines) {
    const what = "problem" in line ? "refused" : line.answer.status === "no_fit" ? "no fit" : line.answer.primitive!.kind;
    counts.set(what, (counts.get(what) ?? 0) + 1);
  }
  return [...counts].map(([what, n]) => counted(n, what, MANY[what])).join(", ");
}
