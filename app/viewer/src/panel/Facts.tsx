/** The answer in words and numbers: the same as the picture, for everyone. */

import type { Answer, Primitive } from "../geometry/kind";
import { degrees, doubted, fixed, plain } from "../numbers";
import * as state from "../state";

const HEADINGS: Record<Answer["status"], (kind: string) => string> = {
  fitted: (kind) => `A ${kind}`,
  ambiguous: (kind) => `A ${kind}, or another`,
  no_fit: (kind) => `No fit; closest is a ${kind}`,
};

export function Facts() {
  const told = state.answer.value;
  if (!told) return null;
  const kind = told.primitive?.kind;
  const warnings = [...told.warnings, ...(told.uncertainty?.warnings.map(({ message }) => message) ?? [])];
  return (
    <section aria-labelledby="verdict">
      <h2 id="verdict" class={told.status}>
        {kind ? HEADINGS[told.status](kind) : "No fit"}
      </h2>
      <p>{told.message}</p>
      {told.alternatives.length > 0 && (
        <p>Also possible: {told.alternatives.map(({ kind }) => `a ${kind}`).join(", ")}.</p>
      )}
      {told.conformance?.verdict && (
        <p class={`verdict ${told.conformance.verdict}`}>
          Tolerances: <strong>{told.conformance.verdict.replace(/_/g, " ")}</strong>
        </p>
      )}
      {warnings.map((each) => (
        <p class="warning" key={each}>
          <span aria-hidden="true">△ </span>
          {each}
        </p>
      ))}
      {told.primitive && <Parameters told={told} primitive={told.primitive} />}
      <Quality told={told} />
    </section>
  );
}

function Parameters({ told, primitive }: { told: Answer; primitive: Primitive }) {
  const unit = told.receipt.unit ?? "";
  return (
    <table>
      <caption>Parameters, ± half of the 95% interval</caption>
      <tbody>
        {Object.entries(primitive)
          .filter(([name]) => name !== "kind")
          .map(([name, value]) => (
            <tr key={name}>
              <th scope="row">{name.replace(/_/g, " ")}</th>
              <td>{Array.isArray(value) ? vector(told, name, value) : scalar(told, name, value as number)}</td>
              <td class="unit">{name === "half_angle" ? "°" : directions.has(name) ? "" : unit}</td>
            </tr>
          ))}
      </tbody>
    </table>
  );
}

const directions = new Set(["axis", "normal"]);

/** Half the width of an interval; null where it is open, or not known. */
function half(told: Answer, name: string): number | null {
  const interval = told.uncertainty?.intervals[name];
  const bounded = interval && interval.low !== null && interval.high !== null;
  return bounded ? (interval.high! - interval.low!) / 2 : null;
}

function scalar(told: Answer, name: string, value: number): string {
  const doubt = half(told, name);
  if (name !== "half_angle") return doubted(value, doubt);
  return doubted(degrees(value), doubt === null ? null : degrees(doubt));
}

/** One doubt for all of a direction, or of a place across the surface; else one for each coordinate. */
function vector(told: Answer, name: string, values: readonly number[]): string {
  const { direction, position } = told.uncertainty ?? {};
  if (directions.has(name)) {
    const row = values.map((each) => fixed(each, 5)).join(" ");
    return direction?.radius_95 ? `${row}\n± ${plain(degrees(direction.radius_95), 2)}°` : row;
  }
  if (position?.radius_95) {
    const row = values.map((each) => doubted(each, position.radius_95).replace(/ ±.*/, "")).join("  ");
    return `${row}\n± ${plain(position.radius_95, 2)} across the ${told.primitive!.kind === "plane" ? "plane" : "axis"}`;
  }
  const each = values.map((value, k) => doubted(value, half(told, `${name}.${"xyz"[k]}`)));
  return each.join(each.some((value) => value.includes("±")) ? "\n" : "  ");
}

function Quality({ told }: { told: Answer }) {
  const { error, noise, receipt, extents } = told;
  const unit = receipt.unit ?? "";
  const rows: [string, string, string][] = [["points", receipt.n_points.toLocaleString("en"), ""]];
  if (error) {
    rows.push(["rms of the inliers", plain(error.inlier_rms, 4), unit]);
    rows.push(["largest distance", plain(error.max, 4), unit]);
    rows.push(["left out as outliers", plain(100 * (1 - error.inlier_share), 3), "%"]);
  }
  if (noise) rows.push(["noise of the points", plain(noise.scale, 4), unit]);
  if (extents) rows.push(["surface covered by points", plain(100 * extents.coverage, 3), "%"]);
  return (
    <table>
      <caption>How well</caption>
      <tbody>
        {rows.map(([name, value, of]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            <td>{value}</td>
            <td class="unit">{of}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
