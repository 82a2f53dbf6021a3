/** The whole page. */

import { render } from "preact";
import { Ask } from "./panel/Ask";
import { Attempts } from "./panel/Attempts";
import { Facts } from "./panel/Facts";
import { Legend } from "./panel/Legend";
import { Picture, view, withDimensions, withSurface } from "./panel/Picture";
import { Picked } from "./panel/Picked";
import { Segments } from "./panel/Segments";
import { Residuals } from "./panel/Residuals";
import { Status } from "./panel/Status";
import { Take } from "./panel/Take";
import { EXAMPLES } from "./examples";
import { keepFocus } from "./focus";
import * as state from "./state";
import { chosen, fitChosen, note, tool, type Tool } from "./tools";

function Page() {
  return (
    <>
      <header>
        <h1>primfit</h1>
        <label class="open">
          Open a file
          <input
            type="file"
            onChange={(event) => {
              const file = event.currentTarget.files?.[0];
              if (file) void state.open(file.name, file);
              event.currentTarget.value = "";
            }}
          />
        </label>
        <select
          aria-label="Examples"
          value=""
          onChange={(event) => {
            const found = EXAMPLES.find(({ name }) => name === event.currentTarget.value);
            event.currentTarget.value = "";
            if (found) void state.open(`${found.name}.xyz`, found.file());
          }}
        >
          <option value="">Examples</option>
          {EXAMPLES.map(({ name }) => (
            <option key={name} value={name}>
              {name}
            </option>
          ))}
        </select>
        <span class="name">{state.source.value?.name}</span>
        <a href="docs">API</a>
      </header>
      <main>
        <div class="stage">
          <Tools />
          <Picture />
          {state.phase.value === "empty" && <p class="hint">Drop a file here</p>}
          <Legend />
        </div>
        <aside id="facts" aria-label="The answer">
          <Status />
          <Picked />
          <Segments />
          <Facts />
          <Attempts />
          <Residuals />
          {state.phase.value !== "empty" && <Ask />}
          <Take />
          <p class="small">
            <a href="viewer/licenses.txt">Licenses</a>
          </p>
        </aside>
      </main>
      <p class="unseen" role="status">
        {state.said.value}
      </p>
    </>
  );
}

function Tools() {
  if (!state.cloud.value) return null;
  const pick = (name: Tool, words: string) => (
    <button
      type="button"
      aria-pressed={tool.value === name}
      onClick={() => (tool.value = tool.value === name ? "look" : name)}
    >
      {words}
    </button>
  );
  return (
    <div class="tools" role="toolbar" aria-label="View">
      <button type="button" onClick={() => view.value?.home()}>
        Whole view
      </button>
      <button
        type="button"
        aria-pressed={withSurface.value}
        onClick={() => (withSurface.value = !withSurface.value)}
      >
        Surface
      </button>
      <button
        type="button"
        aria-pressed={withDimensions.value}
        onClick={() => (withDimensions.value = !withDimensions.value)}
      >
        Dimensions
      </button>
      {pick("measure", "Measure")}
      {pick("lasso", "Lasso")}
      {pick("box", "Box")}
      {chosen.value && (
        <button type="button" class="main" onClick={() => void fitChosen()}>
          Fit the selection
        </button>
      )}
      <p class={note.value ? "note" : "unseen"} role="status">
        {note.value}
      </p>
    </div>
  );
}

addEventListener("hashchange", state.takeLink);
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event: DragEvent) => {
  event.preventDefault();
  const file = event.dataTransfer?.files[0];
  if (file) void state.open(file.name, file);
});
addEventListener("paste", (event: ClipboardEvent) => {
  if (event.target instanceof HTMLInputElement) return;
  const file = event.clipboardData?.files[0];
  const text = event.clipboardData?.getData("text/plain");
  if (file) void state.open(file.name, file);
  else if (text?.trim()) void state.open("pasted.txt", new Blob([text]));
});

const page = document.getElementById("page")!;
keepFocus(page);
render(<Page />, page);
void state.learn();
