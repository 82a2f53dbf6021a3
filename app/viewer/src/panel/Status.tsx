/** Where it stands: what to do first, what is under way, what went wrong. */

import { counted } from "../numbers";
import { key, type Job, type Problem } from "../service/service";
import * as state from "../state";

export function Status() {
  switch (state.phase.value) {
    case "empty":
      return <Empty />;
    case "reading":
      return <p class="status busy">Reading {state.source.value?.name}…</p>;
    case "asking":
      return <p class="status busy">Asking the service…</p>;
    case "canceled":
      return <p class="status">Canceled.{state.answer.value || state.segments.value?.length ? " What was found stays." : ""}</p>;
    case "fitting":
      return (
        <p class="status busy">
          Fitting {underWay()}…{" "}
          <button type="button" onClick={state.cancel}>
            Cancel
          </button>{" "}
          <Keep />
        </p>
      );
    case "offline":
      return (
        <section class="status problem" role="alert">
          <h2>The service does not answer</h2>
          <p>It may have stopped, or the network is down. What is shown here stays.</p>
          <Again />
        </section>
      );
    case "refused":
      return <Refusal />;
    default:
      return null;
  }
}

/** Of a scan: so that it goes on when the page is closed. */
function Keep() {
  if (state.job.value) return <>It goes on if you close this page.</>;
  if (!state.isScan.value || !state.abilities.value?.jobs) return null;
  return (
    <button type="button" onClick={() => void state.keep()}>
      Go on as a job
    </button>
  );
}

function underWay(): string {
  const kept = state.job.value;
  if (kept && !state.isScan.value) return `${counted(state.segments.value?.length ?? 0, "segment")} so far`;
  const points = state.preview.value;
  if (!points) return state.source.value?.name ?? "";
  if (!state.isScan.value) return counted(points.n, "point");
  return `${state.segments.value?.length ?? 0} of ${counted(points.labels!.names.length, "segment")}`;
}

function Empty() {
  return (
    <section class="status">
      <h2>Which primitive is it?</h2>
      <p>
        Open a file with the points of one surface, drop it anywhere, or paste rows of coordinates. CSV, PLY, LAS, E57,
        STL and others are read.
      </p>
      {state.kept.value.length > 0 && (
        <>
          <h3>Jobs</h3>
          <ul class="jobs">
            {state.kept.value.map((each) => (
              <Kept key={each.jobID} job={each} />
            ))}
          </ul>
        </>
      )}
    </section>
  );
}

function Kept({ job }: { job: Job }) {
  const ended = state.isOver(job);
  const when = new Date(job.created).toLocaleString();
  return (
    <li>
      <span>
        {when}: {ended ? job.status : `${job.status}, ${job.progress}%`}
      </span>
      <button type="button" aria-label={`Show the job of ${when}`} onClick={() => void state.show(job)}>
        Show
      </button>
      <button type="button" aria-label={`${ended ? "Remove" : "Cancel"} the job of ${when}`} onClick={() => void state.drop(job)}>
        {ended ? "Remove" : "Cancel"}
      </button>
    </li>
  );
}

function Again() {
  return (
    <button type="button" onClick={() => void state.again()}>
      Try again
    </button>
  );
}

/** Whether the same may be answered later; what is wrong with a file or an option has to be changed first. */
const mayPass = ({ status }: Problem): boolean => status === 429 || status >= 500 || !state.source.value;

function Refusal() {
  const told = state.problem.value;
  if (!told) return null;
  const more = (told.errors ?? []).filter(({ message }) => !told.detail.includes(message));
  return (
    <section class="status problem" role="alert">
      <h2>{told.title}</h2>
      <p>{told.detail}</p>
      {more.length > 0 && (
        <ul>
          {more.map(({ field, message, value }) => (
            <li key={field}>
              <strong>{field}</strong>: {message}
              {value !== null && value !== undefined && ` (given: ${value})`}
            </li>
          ))}
        </ul>
      )}
      {told.status === 401 ? <Key /> : mayPass(told) && <Again />}
    </section>
  );
}

function Key() {
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        key.set(String(new FormData(event.currentTarget).get("key")));
        void state.again();
      }}
    >
      <label class="row">
        Key <input name="key" type="password" autocomplete="off" required />
      </label>
      <button type="submit" class="main">
        Use it
      </button>
    </form>
  );
}
