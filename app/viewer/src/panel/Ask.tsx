/** What is asked of the service: kinds, criterion, tolerance, and what is known already. */

import type { Options } from "../service/service";
import * as state from "../state";

export function Ask() {
  const known = state.abilities.value;
  if (!known) return null;
  const { kinds = known.kinds, criterion = "robust", tolerance = null } = state.options.value;
  const toggle = (kind: string, on: boolean): void => {
    const left = known.kinds.filter((each) => (each === kind ? on : (kinds as readonly string[]).includes(each)));
    state.set("kinds", left.length && left.length < known.kinds.length ? (left as Options["kinds"]) : null);
  };
  return (
    <section aria-labelledby="ask">
      <h2 id="ask">Fit again</h2>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          void state.refit();
        }}
      >
        <fieldset>
          <legend>Kinds</legend>
          {known.kinds.map((kind) => (
            <label key={kind}>
              <input
                type="checkbox"
                checked={(kinds as readonly string[]).includes(kind)}
                onChange={(event) => toggle(kind, event.currentTarget.checked)}
              />{" "}
              {kind}
            </label>
          ))}
        </fieldset>
        <label class="row">
          Criterion
          <select
            value={criterion}
            onChange={(event) => {
              const name = event.currentTarget.value as Options["criterion"];
              state.set("criterion", name === "robust" ? null : name);
            }}
          >
            {known.criteria.map((name) => (
              <option key={name} value={name}>
                {name.replace(/_/g, " ")}
              </option>
            ))}
          </select>
        </label>
        <label class="row">
          Tolerance {state.unit.value && `[${state.unit.value}]`}
          <input
            type="text"
            inputMode="decimal"
            placeholder="none"
            value={tolerance ?? ""}
            onChange={(event) => state.set("tolerance", number(event.currentTarget.value))}
          />
        </label>
        <Known />
        <button type="submit" class="main" disabled={!state.source.value}>
          Fit
        </button>
      </form>
    </section>
  );
}

/** A radius or a direction that is known; they are the constraints that people have most. */
function Known() {
  const constraints: Partial<NonNullable<Options["constraints"]>> = state.options.value.constraints ?? {};
  const { radius, axis } = constraints;
  const put = (name: "radius" | "axis", value: unknown): void => {
    const { [name]: _, ...others } = constraints;
    const all = value === null ? others : { ...others, [name]: value };
    state.set("constraints", Object.keys(all).length ? (all as Options["constraints"]) : null);
  };
  const fixed = (value: number | null): unknown => (value === null ? null : { value });
  return (
    <>
      <label class="row">
        Known radius {state.unit.value && `[${state.unit.value}]`}
        <input
          type="text"
          inputMode="decimal"
          placeholder="free"
          value={(radius && "value" in radius ? radius.value : null) ?? ""}
          onChange={(event) => put("radius", fixed(number(event.currentTarget.value)))}
        />
      </label>
      <label class="row">
        Known axis
        <input
          type="text"
          placeholder="free, or as 0 0 1"
          value={axis?.direction.join(" ") ?? ""}
          onChange={(event) => put("axis", direction(event.currentTarget.value))}
        />
      </label>
    </>
  );
}

const number = (text: string): number | null => {
  const value = Number(text.replace(",", "."));
  return text.trim() === "" || !Number.isFinite(value) ? null : value;
};

function direction(text: string): unknown {
  const value = text
    .trim()
    .split(/[\s,;]+/)
    .map(Number);
  return value.length === 3 && value.every(Number.isFinite) ? { direction: value, max_angle: 0 } : null;
}
