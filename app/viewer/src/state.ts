/** What the page shows, and how it comes about: everything that changes is a signal. */

import { computed, effect, signal } from "@preact/signals";
import { wrap } from "comlink";
import { Cloud } from "./cloud";
import { distanceTo } from "./geometry/kinds";
import type { Answer, Extents, Primitive } from "./geometry/kind";
import { ofLink, toLink, type Chosen } from "./options";
import type { Reader } from "./reading/reader";
import type { Coloring } from "./scene/points";
import {
  Refused,
  artifact,
  capabilities,
  dismiss,
  fit,
  fitEach,
  jobOf,
  jobs,
  resultsOf,
  submit,
  type Capabilities,
  type Fit,
  type Job,
  type Line,
  type Options,
  type Problem,
  type Source,
} from "./service/service";

export type Phase = "empty" | "reading" | "asking" | "fitting" | "answered" | "canceled" | "refused" | "offline";

export const phase = signal<Phase>("empty");
export const source = signal<Source | null>(null);
/** As the page has read it; null where only the service can. */
export const preview = signal<Cloud | null>(null);
export const outcome = signal<Fit | null>(null);
/** Where a scan has labels: what came of each of its segments so far, and the one that is looked at. */
export const segments = signal<readonly Line[] | null>(null);
export const segment = signal<number | null>(null);
/** The job whose segments are shown, and all that the service keeps for this user. */
export const job = signal<Job | null>(null);
export const kept = signal<readonly Job[]>([]);
export const problem = signal<Problem | null>(null);
export const abilities = signal<Capabilities | null>(null);
export const options = signal<Chosen>(ofLink(location.hash));
/** The step of the answer that is looked at; null for the answer itself. */
export const step = signal<number | null>(null);
export const coloring = signal<Coloring>("residual");
/** The residual at which the colors end, where somebody has set it. */
export const chosenLimit = signal<number | null>(null);
/** For screen readers: what has come about. */
export const said = signal("");
/** What came of the last file that was taken along. */
export const taken = signal<{ words: string; failed: boolean } | null>(null);

export const answer = computed<Answer | null>(() => {
  if (segments.value === null) return outcome.value?.answer ?? null;
  const line = segment.value === null ? null : segments.value[segment.value];
  return line && "answer" in line ? line.answer : null;
});
export const cloud = computed<Cloud | null>(() => outcome.value?.points?.cloud ?? preview.value);
export const isScan = computed(() => (preview.value?.labels?.names.length ?? 0) > 1);
export const unit = computed(() => {
  const told = answer.value ?? segments.value?.find((line) => "answer" in line)?.answer;
  return told?.receipt.unit ?? "";
});

/** The surface that is shown, and its piece where that is known. */
export const shown = computed<{ primitive: Primitive; extents: Extents | null } | null>(() => {
  const told = answer.value;
  if (!told) return null;
  const attempt = step.value === null ? null : told.attempts[step.value];
  if (attempt?.primitive && !same(attempt.primitive, told.primitive)) {
    const other = told.alternatives.find((each) => each.kind === attempt.kind);
    return { primitive: attempt.primitive, extents: other?.extents ?? null };
  }
  return told.primitive ? { primitive: told.primitive, extents: told.extents } : null;
});

/** 1 for each point of the segment that is looked at; null for no segment. */
export const members = computed<Uint8Array | null>(() => {
  const [labels, line] = [preview.value?.labels, segment.value === null ? null : segments.value?.[segment.value]];
  if (!labels || !line) return null;
  const place = labels.names.indexOf(line.label!);
  return Uint8Array.from(labels.of, (each) => Number(each === place));
});

/** Signed distances of the points from what is shown: those of the service, or of another step ours.
 *
 * NaN for points of other segments.
 */
export const residuals = computed<Float64Array | null>(() => {
  const [points, at, mine] = [cloud.value, shown.value, members.value];
  if (!points || !at) return null;
  const told = outcome.value;
  if (told?.points && same(at.primitive, told.answer.primitive)) return told.points.residuals;
  const distances = points.map(distanceTo(at.primitive));
  return mine ? distances.map((each, i) => (mine[i] ? each : NaN)) : distances;
});

export const inliers = computed<Uint8Array | null>(() => outcome.value?.points?.inliers ?? null);

/** At this residual the colors end: 99 % of the inliers are within it, as in the files of the service. */
export const limit = computed<number>(() => {
  if (chosenLimit.value !== null) return chosenLimit.value;
  const [values, inlying] = [residuals.value, inliers.value];
  if (!values) return 0;
  const sizes = values.filter((each, i) => each === each && (!inlying || inlying[i] === 1)).map(Math.abs).sort();
  return sizes.length ? sizes[Math.floor(0.99 * (sizes.length - 1))] || sizes[sizes.length - 1] : 0;
});

const same = (a: unknown, b: unknown): boolean => JSON.stringify(a) === JSON.stringify(b);

/** Milliseconds: between two looks at a job, and for which the service waits until points are shown. */
const [LOOK, MOMENT] = [1000, 150];
const pause = (time: number): Promise<void> => new Promise((done) => setTimeout(done, time));
const reader = wrap<Reader>(new Worker("viewer/reader.js", { type: "module" }));
let underWay: AbortController | null = null;

/** Read a file, show its points, and have it fitted. */
export async function open(name: string, file: Blob): Promise<void> {
  const given = { name, file };
  if (job.value && !source.value && (await joins(given))) return;
  forget();
  source.value = given;
  phase.value = "reading";
  const labelled = await reader.isLabelled(file).catch(() => false);
  const shown = read(given);
  // Points first, if that is a matter of moments; labels decide what is asked.
  await (labelled ? shown : Promise.race([shown, pause(MOMENT)]));
  if (source.value === given) await refit();
}

/** Begin anew, with nothing. */
function forget(): void {
  underWay?.abort();
  source.value = outcome.value = preview.value = problem.value = step.value = chosenLimit.value = taken.value = null;
  segments.value = segment.value = job.value = null;
  coloring.value = "residual";
}

/** Show the points of a file, where the page reads its format. */
async function read(given: Source): Promise<void> {
  const read = await cloudOf(given);
  if (read && source.value === given) preview.value = read;
}

async function cloudOf({ file }: Source): Promise<Cloud | null> {
  const parts = await reader.read(file).catch(() => null);
  return parts && new Cloud(parts.xyz, parts.labels);
}

/** Show the points of a job, whose segments are there already; false if it has none of the labels of the file. */
async function joins(given: Source): Promise<boolean> {
  const [read, found] = [await cloudOf(given), segments.value ?? []];
  const names = read?.labels?.names ?? [];
  if (!names.length || (found.length && !found.some(({ label }) => names.includes(label!)))) return false;
  source.value = given;
  preview.value = read;
  return true;
}

/** Fit the same file with the options as they are now. */
export async function refit(): Promise<void> {
  const given = source.value;
  if (!given || !(abilities.value || (await learn()))) return;
  await work((signal) => (isScan.value ? fitSegments : fitWhole)(given, signal));
}

/** Ask once more what the service did not answer. */
export async function again(): Promise<void> {
  phase.value = "asking";
  if (!(await learn()) || phase.value !== "asking") return;
  const followed = job.value;
  if (followed) await watch(() => followed);
  else if (source.value) await refit();
  else phase.value = "empty";
}

/** Do something that may be canceled, and say what came of it. */
async function work(task: (signal: AbortSignal) => Promise<void>): Promise<void> {
  underWay?.abort();
  const mine = (underWay = new AbortController());
  phase.value = "fitting";
  problem.value = step.value = job.value = taken.value = null;
  try {
    await task(mine.signal);
    if (!mine.signal.aborted) phase.value = "answered";
  } catch (error) {
    if (mine.signal.aborted) return;
    if (error instanceof Refused) outcome.value = null;
    refuse(error);
  } finally {
    if (underWay === mine) underWay = null;
  }
}

function refuse(error: unknown): void {
  problem.value = error instanceof Refused ? error.problem : null;
  phase.value = error instanceof Refused ? "refused" : "offline";
}

async function fitWhole(given: Source, signal: AbortSignal): Promise<void> {
  const told = await fit(given, () => preview.value, options.value as Options, signal);
  outcome.value = told;
  said.value = told.answer.message;
}

async function fitSegments(given: Source, signal: AbortSignal): Promise<void> {
  segments.value = [];
  segment.value = null;
  coloring.value = "kind";
  await fitEach(given, options.value as Options, signal, (line) => {
    segments.value = [...segments.value!, line];
  });
  said.value = `${segments.value.length} segments are fitted.`;
}

/** Have the segments fitted as a job, which goes on without the page. */
export async function keep(): Promise<void> {
  const given = source.value;
  if (given) await watch(() => submit(given, options.value as Options));
}

/** Show what a job has found so far, and what it finds from now on. */
export async function show(chosen: Job): Promise<void> {
  forget();
  await watch(() => chosen);
}

async function watch(begin: () => Job | Promise<Job>): Promise<void> {
  await work(async (signal) => {
    segments.value = [];
    segment.value = null;
    coloring.value = "kind";
    await follow(await begin(), signal);
  });
}

async function follow(chosen: Job, signal: AbortSignal): Promise<void> {
  job.value = chosen;
  for (let [rows, more] = [0, true]; more; ) {
    const page = await resultsOf(chosen.jobID, rows, signal);
    rows += page.rows;
    more = page.more;
    segments.value = [...(segments.value ?? []), ...page.lines];
    job.value = await jobOf(chosen.jobID, signal);
    if (more && !page.rows) await pause(LOOK);
  }
  said.value = `The job is ${job.value.status}; ${segments.value!.length} segments are fitted.`;
}

/** Cancel or remove a job. */
export async function drop(which: Job): Promise<void> {
  try {
    await dismiss(which.jobID);
    await recall();
  } catch (error) {
    refuse(error);
  }
}

async function recall(): Promise<void> {
  kept.value = abilities.value?.jobs ? await jobs() : [];
}

export const isOver = ({ finished }: Job): boolean => finished !== undefined && finished !== null;

/** Jobs that are listed are looked at until they are over. */
effect(() => {
  if (phase.value !== "empty" || kept.value.every(isOver)) return;
  const timer = setTimeout(() => void recall().catch(() => undefined), LOOK);
  return () => clearTimeout(timer);
});

/** Give up the fit that is under way; what was shown stays. */
export function cancel(): void {
  if (job.value) void drop(job.value);
  underWay?.abort();
  phase.value = "canceled";
}

export async function download(which: string): Promise<void> {
  const given = source.value;
  if (!given) return;
  taken.value = { words: `${which.replace(/_/g, " ")} is made…`, failed: false };
  try {
    const [name, content] = await artifact(given, options.value as Options, which);
    save(`${given.name.replace(/\.[^.]*$/, "")}-${name}`, content);
  } catch (error) {
    const words = error instanceof Refused ? error.problem.detail : "The service does not answer.";
    taken.value = { words, failed: true };
  }
}

/** Have the browser keep a file. */
export function save(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  taken.value = { words: `${name} is saved.`, failed: false };
}

/** Learn what the service can do; false if it does not say. */
export async function learn(): Promise<boolean> {
  try {
    abilities.value = await capabilities();
    await recall();
    return true;
  } catch (error) {
    refuse(error);
    return false;
  }
}

/** Set an option, or leave it to the service where there is no value; the address of the page holds them. */
export function set<K extends keyof Options>(name: K, value: Options[K] | null): void {
  const { [name]: _, ...others } = options.value;
  options.value = value === null ? (others as Chosen) : { ...others, [name]: value };
  history.replaceState(null, "", toLink(options.value));
}

/** Take the options of another address that the page is given. */
export function takeLink(): void {
  options.value = ofLink(location.hash);
}
