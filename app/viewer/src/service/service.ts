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

/** The answer about a file with the residuals of its points, by one call. */
export async function fit(file: Blob, name: string, options: Options, signal: AbortSignal): Promise<Fit> {
  const response = await ask("fit/export?artifacts=residuals_ply", posted(file, name, options, signal));
  if (response.status === 422) {
    const problem: Problem = await response.json();
    if (!problem.type.endsWith(":nothing-to-export")) throw new Refused(problem);
    const plain = await accepted(await ask("fit", posted(file, name, options, signal)));
    return { answer: await plain.json(), points: null };
  }
  const files = await unzipped(new Uint8Array(await (await accepted(response)).arrayBuffer()));
  const answer: Answer = JSON.parse(new TextDecoder().decode(files.get("answer.json")));
  const residuals = files.get(RESIDUALS);
  return { answer, points: residuals ? pointsOf(residuals) : null };
}

export type Line = Schemas["BatchAnswer"] | Schemas["BatchProblem"];

/** The segments of a file by their labels, told one by one as they are done. */
export async function fitEach(
  file: Blob,
  name: string,
  options: Options,
  signal: AbortSignal,
  tell: (line: Line) => void,
): Promise<void> {
  const response = await accepted(await ask("fit/batch?labels=auto", posted(file, name, options, signal)));
  const lines = response.body!.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (let piece = await lines.read(); !piece.done; piece = await lines.read()) {
    const whole = (rest + piece.value).split("\n");
    rest = whole.pop()!;
    for (const line of whole) {
      const told: Line | Schemas["BatchSummary"] = JSON.parse(line);
      if (!("summary" in told)) tell(told);
    }
  }
}

/** One file that the service makes of the answer, ready to be kept. */
export async function artifact(file: Blob, name: string, options: Options, which: string): Promise<[string, Blob]> {
  const path = `fit/export?artifacts=${encodeURIComponent(which)}`;
  const response = await accepted(await ask(path, posted(file, name, options)));
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

function pointsOf(bytes: Uint8Array): FittedPoints {
  const vertices = headerOf(bytes)!;
  const column = (name: string): Float64Array =>
    columnOf(bytes, vertices, vertices.properties.findIndex((property) => property.name === name));
  const [x, y, z] = ["x", "y", "z"].map(column);
  const xyz = new Float64Array(3 * vertices.n);
  for (let i = 0; i < vertices.n; i++) xyz.set([x[i], y[i], z[i]], 3 * i);
  return { cloud: new Cloud(xyz), residuals: column("residual"), inliers: Uint8Array.from(column("inlier")) };
}

function posted(file: Blob, name: string, options: Options, signal?: AbortSignal): RequestInit {
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
  throw new Refused(await response.json().catch(() => plain(response)));
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
