/** What can be taken along: files, and the lines that give the same answer elsewhere. */

import { signal } from "@preact/signals";
import * as state from "../state";

const copied = signal("");

export function Take() {
  const [known, given] = [state.abilities.value, state.source.value];
  if (!known || !given || !state.answer.value) return null;
  return (
    <section aria-labelledby="take">
      <h2 id="take">Take along</h2>
      <div class="buttons">
        {known.artifacts.map((name) => (
          <button type="button" key={name} onClick={() => void state.download(name)}>
            {name.replace(/_/g, " ")}
          </button>
        ))}
      </div>
      <div class="buttons">
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

function curl(): string {
  const options = JSON.stringify(state.options.value);
  const asked = options === "{}" ? "" : ` -F ${quoted(`options=${options}`)}`;
  return `curl ${new URL("fit", location.href).href} -F ${quoted(`file=@${state.source.value!.name}`)}${asked}`;
}

function python(): string {
  const said = Object.entries(state.options.value).map(([name, value]) => `, ${name}=${literal(value)}`);
  return `import primfit\n\nanswer = primfit.fit(${JSON.stringify(state.source.value!.name)}${said.join("")})\nprint(answer.primitive)`;
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
