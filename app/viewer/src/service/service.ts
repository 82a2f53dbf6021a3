/** What the page asks of the service: its public operations, and nothing else. */

import { Cloud } from "../cloud";
import type { Answer } from "../geometry/kind";
import { columnOf, headerOf } from "../reading/ply";
import type { components } from "../schema";
import { unzipped } from "./archive";

type Schemas = components["schemas"];
export type Problem = Schemas["Problem"];
export type Capabilities = Schemas["Capabilities"];
export type Options = Schemas["FitOptions"];
export type Job = Schemas["JobStatus"];

export interface Source {
  readonly name: string;
  readonly file: Blob;
}

export interface Fit {
  readonly answer: Answer;
  /** The points that the service read, with what it says of each; null where nothing was fitted. */
  readonly points: FittedPoints | null;
}

export interface FittedPoints {
  readonly cloud: Cloud;
  readonly residuals: Float64Array;
  readonly inliers: Uint8Array;
}

/** Thrown where the service refuses, in its words. */
export class Refused extends Error {
  constructor(readonly problem: Problem) {
    super(problem.detail);
  }
}

/** Of the API key: it is kept as long as the tab. */
const KEY = "primfit-key";
const RESIDUALS = "residuals.ply";

export const key = {
  get: (): string => sessionStorage.getItem(KEY) ?? "",
  set: (value: string): void => sessionStorage.setItem(KEY, value),
};

/** The answer about a file with the residuals of its points, by one call; `seen` is what the page has read of it. */
export async function fit(
  given: Source,
  seen: () => Cloud | null,
  options: Options,
  signal: AbortSignal,
): Promise<Fit> {
  const response = await ask("fit/export?artifacts=residuals_ply", posted(given, options, signal));
  if (response.status === 422) {
    const problem = await problemOf(response);
    if (!problem.type.endsWith(":nothing-to-export")) throw new Refused(problem);
    const plain = await accepted(await ask("fit", posted(given, options, signal)));
    return { answer: await plain.json(), points: null };
  }
  const files = await unzipped(new Uint8Array(await (await accepted(response)).arrayBuffer()));
  const answer: Answer = JSON.parse(new TextDecoder().decode(files.get("answer.json")));
  const residuals = files.get(RESIDUALS);
  return { answer, points: residuals ? pointsOf(residuals, seen()) : null };
}

export type Line = Schemas["BatchAnswer"] | Schemas["BatchProblem"];

/** The segments of a file by their labels, told one by one as they are done. */
export async function fitEach(
  given: Source,
  options: Options,
  signal: AbortSignal,
  tell: (line: Line) => void,
): Promise<void> {
  const response = await accepted(await ask("fit/batch?labels=auto", posted(given, options, signal)));
  const lines = response.body!.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (let piece = await lines.read(); !piece.done; piece = await lines.read()) {
    const whole = (rest + piece.value).split("\n");
    rest = whole.pop()!;
    linesOf(whole).forEach(tell);
  }
}

/** What is told of segments, without the summary. */
function linesOf(rows: readonly string[]): Line[] {
  const told: (Line | Schemas["BatchSummary"])[] = rows.map((row) => JSON.parse(row));
  return told.filter((each): each is Line => !("summary" in each));
}

/** Have the segments of a file fitted as a job, which goes on when the page is closed. */
export async function submit(given: Source, options: Options): Promise<Job> {
  return (await accepted(await ask("jobs?labels=auto", posted(given, options)))).json();
}

export async function jobs(): Promise<readonly Job[]> {
  const told: Schemas["JobList"] = await (await accepted(await ask("jobs", {}))).json();
  return told.jobs;
}

export async function jobOf(id: string, signal?: AbortSignal): Promise<Job> {
  return (await accepted(await ask(`jobs/${id}`, { signal }))).json();
}

export interface Page {
  readonly rows: number;
  readonly lines: readonly Line[];
  /** Whether more may come. */
  readonly more: boolean;
}

/** What was found, without so many rows that are known. */
export async function resultsOf(id: string, offset: number, signal: AbortSignal): Promise<Page> {
  const response = await accepted(await ask(`jobs/${id}/results?offset=${offset}`, { signal }));
  const rows = (await response.text()).split("\n").slice(0, -1);
  return { rows: rows.length, lines: linesOf(rows), more: response.headers.has("Link") };
}

/** Cancel a job, or remove one that has ended. */
export async function dismiss(id: string): Promise<void> {
  await accepted(await ask(`jobs/${id}`, { method: "DELETE" }));
}

/** One file that the service makes of the answer, ready to be kept. */
export async function artifact(given: Source, options: Options, which: string): Promise<[string, Blob]> {
  const path = `fit/export?artifacts=${encodeURIComponent(which)}`;
  const response = await accepted(await ask(path, posted(given, options)));
  const files = await unzipped(new Uint8Array(await response.arrayBuffer()));
  for (const [called, content] of files) {
    if (called !== "answer.json" && called !== "problems.json") return [called, new Blob([content])];
  }
  const [problem]: Problem[] = JSON.parse(new TextDecoder().decode(files.get("problems.json")));
  throw new Refused(problem);
}

export async function capabilities(): Promise<Capabilities> {
  return (await accepted(await ask("capabilities", {}))).json();
}

function pointsOf(bytes: Uint8Array, seen: Cloud | null): FittedPoints {
  const vertices = headerOf(bytes)!;
  const column = (name: string): Float64Array =>
    columnOf(bytes, vertices, vertices.properties.findIndex((property) => property.name === name));
  const xyz = ["x", "y", "z"].map(column);
  const cloud = seen && areOf(seen, xyz) ? seen : new Cloud(together(xyz));
  return { cloud, residuals: column("residual"), inliers: Uint8Array.from(column("inlier")) };
}

/** Whether a cloud has these coordinates: it is in the picture already, and stays there. */
const areOf = (cloud: Cloud, columns: readonly Float64Array[]): boolean =>
  columns[0].length === cloud.n &&
  columns.every((column, k) => column.every((each, i) => each === cloud.xyz[3 * i + k]));

function together(columns: readonly Float64Array[]): Float64Array {
  const xyz = new Float64Array(3 * columns[0].length);
  columns.forEach((column, k) => column.forEach((each, i) => (xyz[3 * i + k] = each)));
  return xyz;
}

function posted({ name, file }: Source, options: Options, signal?: AbortSignal): RequestInit {
  const body = new FormData();
  body.append("file", file, name);
  body.append("options", JSON.stringify(options));
  return { method: "POST", body, signal };
}

function ask(path: string, init: RequestInit): Promise<Response> {
  const given = key.get();
  return fetch(path, { ...init, headers: given ? { "X-API-Key": given } : {} });
}

async function accepted(response: Response): Promise<Response> {
  if (response.ok) return response;
  throw new Refused(await problemOf(response));
}

async function problemOf(response: Response): Promise<Problem> {
  const told = await response.json().catch(() => null);
  return told?.title && told.type ? told : plain(response);
}

/** Of an answer that is none of the service's: that of a proxy, say. */
const plain = (response: Response): Problem => ({
  type: "about:blank",
  title: response.statusText || "The request failed",
  status: response.status,
  detail: `The server answered with status ${response.status}.`,
  instance: "",
  errors: [],
});
