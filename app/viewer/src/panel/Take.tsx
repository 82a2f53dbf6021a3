/** What can be taken along: files, and the lines that give the same answer elsewhere. */

import { signal } from "@preact/signals";
import { key } from "../service/service";
import * as state from "../state";

const copied = signal("");

export function Take() {
  const [known, given, taken] = [state.abilities.value, state.source.value, state.taken.value];
  const isScan = state.segments.value !== null;
  if (!known || !given || !(isScan ? state.segments.value!.length : state.answer.value)) return null;
  return (
    <section aria-labelledby="take">
      <h2 id="take">Take along</h2>
      {!isScan && (
        <div class="buttons">
          {known.artifacts.map((name) => (
            <button type="button" key={name} onClick={() => void state.download(name)}>
              {name.replace(/_/g, " ")}
            </button>
          ))}
        </div>
      )}
      {taken && (
        <p role="status" class={taken.failed ? "warning" : undefined}>
          {taken.words}
        </p>
      )}
      <div class="buttons">
        {!(given.file instanceof File) && (
          <button type="button" onClick={() => state.save(given.name, given.file)}>
            Save the points
          </button>
        )}
        <Copy name="curl" text={curl} />
        <Copy name="Python" text={python} />
        <Copy name="link with these options" text={() => location.href} />
      </div>
      {copied.value && <pre>{copied.value}</pre>}
    </section>
  );
}

function Copy({ name, text }: { name: string; text: () => string }) {
  const copy = async (): Promise<void> => {
    copied.value = text();
    await navigator.clipboard?.writeText(copied.value).catch(() => undefined);
    state.said.value = `${name} is copied.`;
  };
  return (
    <button type="button" onClick={() => void copy()}>
      Copy {name}
    </button>
  );
}

const quoted = (text: string): string => `'${text.replace(/'/g, `'\\''`)}'`;

/** The key itself stays in the page: the line takes it from the environment. */
function curl(): string {
  const options = JSON.stringify(state.options.value);
  const asked = options === "{}" ? "" : ` --form-string ${quoted(`options=${options}`)}`;
  const allowed = key.get() ? ' -H "X-API-Key: $PRIMFIT_KEY"' : "";
  const address = new URL(state.segments.value ? "fit/batch?labels=auto" : "fit", location.href).href;
  // In quotes of its own a name may hold what means something to curl.
  const name = state.source.value!.name.replace(/[\\"]/g, "\\$&");
  return `curl ${quoted(address)}${allowed} -F ${quoted(`file=@"${name}"`)}${asked}`;
}

function python(): string {
  const said = Object.entries(state.options.value).map(([name, value]) => `, ${name}=${literal(value)}`).join("");
  const name = JSON.stringify(state.source.value!.name);
  const lines = state.segments.value
    ? [`for segment in primfit.fit_segments(primfit.read(${name}, labels="auto")${said}):`, "    print(repr(segment))"]
    : [`answer = primfit.fit(${name}${said})`, "print(answer.primitive)"];
  return ["import primfit", "", ...lines].join("\n");
}

function literal(value: unknown): string {
  if (value === null) return "None";
  if (typeof value === "boolean") return value ? "True" : "False";
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (typeof value !== "object") return JSON.stringify(value);
  return `{${Object.entries(value as object)
    .map(([name, each]) => `${JSON.stringify(name)}: ${literal(each)}`)
    .join(", ")}}`;
}
