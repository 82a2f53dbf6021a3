/** What is asked of the service: kinds, criterion, tolerance, and what is known already. */

import { UNITS, fielded, type Chosen } from "../options";
import type { Options } from "../service/service";
import * as state from "../state";

export function Ask() {
  const known = state.abilities.value;
  if (!known) return null;
  const shown = fielded(state.options.value, known);
  const { kinds = known.kinds, criterion = "robust", tolerance = null, unit = "" } = shown;
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
          Unit of the file
          <select
            value={unit ?? ""}
            onChange={(event) => state.set("unit", (event.currentTarget.value || null) as Options["unit"])}
          >
            <option value="">as it says</option>
            {UNITS.map((name) => (
              <option key={name} value={name}>
                {name}
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
            onChange={(event) => state.set("tolerance", entered(event.currentTarget, number, NUMBER))}
          />
        </label>
        <Known shown={shown} />
        <Others shown={shown} />
        <button type="submit" class="main" disabled={!state.source.value}>
          Fit
        </button>
      </form>
    </section>
  );
}

/** A radius or a direction that is known; they are the constraints that people have most. */
function Known({ shown }: { shown: Chosen }) {
  const constraints: Partial<NonNullable<Options["constraints"]>> = shown.constraints ?? {};
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
          onChange={(event) => put("radius", fixed(entered(event.currentTarget, number, NUMBER)))}
        />
      </label>
      <label class="row">
        Known axis
        <input
          type="text"
          placeholder="free, or as 0 0 1"
          value={axis?.direction.join(" ") ?? ""}
          onChange={(event) => put("axis", entered(event.currentTarget, direction, DIRECTION))}
        />
      </label>
    </>
  );
}

/** What a link asks for beyond the fields, such as a seed: in its own words, to be left out. */
function Others({ shown }: { shown: Chosen }) {
  const names = (Object.keys(state.options.value) as (keyof Options)[]).filter((name) => !(name in shown));
  return (
    <>
      {names.map((name) => (
        <p class="row other" key={name}>
          <span>
            {name.replace(/_/g, " ")}: <code>{JSON.stringify(state.options.value[name])}</code>
          </span>
          <button type="button" aria-label={`Leave out ${name.replace(/_/g, " ")}`} onClick={() => state.set(name, null)}>
            Leave out
          </button>
        </p>
      ))}
    </>
  );
}

const [NUMBER, DIRECTION] = ["A number is needed, such as 0.5.", "Three numbers are needed, such as 0 0 1."];

/** What was entered; what cannot be read is marked, and the form waits until it is mended. */
function entered<T>(input: HTMLInputElement, read: (text: string) => T | null, needed: string): T | null {
  const value = read(input.value);
  input.setCustomValidity(value === null && input.value.trim() ? needed : "");
  return value;
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
