// Drives a running service through every operation of its document: node built/drive.js URL CLOUD.csv
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { connect, describe, form, type BatchLine, type Options } from "./client.js";

const [url = "http://127.0.0.1:8000", path = "../../../app/examples/cylinder.csv"] = process.argv.slice(2);
const client = connect(url);
const cloud = await readFile(path, "utf8");
const file = new File([cloud], "cylinder.csv", { type: "text/csv" });
const points = cloud.split("\n").slice(2).filter(Boolean).map((line) => line.split(",").map(Number));

const driven = new Set<string>();
client.use({ onRequest: ({ request, schemaPath }) => void driven.add(`${request.method.toLowerCase()} ${schemaPath}`) });

await fitJson();
await fitUpload();
await fitRaw();
await fitBatch();
await fitExport();
await jobs();
await problems();
await service();
await nothingIsLeftOut();

async function fitJson() {
  const options: Options = { kinds: ["cylinder", "cone"], seed: 3 };
  const { data, response } = await client.POST("/fit", {
    body: { points, options },
    params: { header: { "X-Request-Id": "typescript-1" } },
  });
  assert.ok(data?.primitive);
  assert.equal(data.receipt.options.seed, 3);
  assert.equal(response.headers.get("X-Request-Id"), "typescript-1");
  assert.match(describe(data.primitive), /^cylinder of radius 12\.\d+$/);
}

async function fitUpload() {
  const { data } = await client.POST("/fit", { body: { file, options: { kinds: ["cylinder"] } }, bodySerializer: form });
  assert.equal(data?.primitive?.kind, "cylinder");
  assert.deepEqual(data.receipt.options.kinds, ["cylinder"]);
}

async function fitRaw() {
  const { data } = await client.POST("/fit", {
    body: file,
    bodySerializer: (body) => body,
    headers: { "Content-Type": "text/csv" },
    params: { query: { kinds: ["sphere"], max_error: 0.5 } },
  });
  assert.equal(data?.primitive?.kind, "sphere");
  assert.equal(data.receipt.n_points, points.length);
}

async function fitBatch() {
  const { response } = await client.POST("/fit/batch", {
    body: { file: [file, file], options: { kinds: ["cylinder"] } },
    bodySerializer: form,
    parseAs: "stream",
  });
  const lines = (await response.text()).trim().split("\n").map((line): BatchLine => JSON.parse(line));
  const kinds = lines.map((line) => ("answer" in line ? line.answer.primitive?.kind : undefined));
  assert.deepEqual(kinds, ["cylinder", "cylinder", undefined]);
  const last = lines.at(-1);
  assert.ok(last && "summary" in last && last.summary.fitted === 2);
}

async function fitExport() {
  const { data } = await client.POST("/fit/export", {
    params: { query: { artifacts: ["step", "glb"], unit: "mm" } },
    body: { points },
    parseAs: "blob",
  });
  assert.ok(data && data.size > 1000);
}

async function jobs() {
  const { data: accepted, response } = await client.POST("/jobs", {
    body: { file: [file, file] },
    bodySerializer: form,
    params: { header: { "Idempotency-Key": `typescript-${Date.now()}` } },
  });
  assert.ok(accepted);
  assert.equal(response.status, 202);
  const of = { path: { job_id: accepted.jobID } };
  const events = await client.GET("/jobs/{job_id}/events", { params: of, parseAs: "text" });
  assert.match(events.data ?? "", /^id: end$/m);
  const { data: ended } = await client.GET("/jobs/{job_id}", { params: of });
  assert.equal(ended?.status, "successful");
  assert.equal(ended.summary?.fitted, 2);
  const page = await client.GET("/jobs/{job_id}/results", {
    params: { ...of, query: { offset: 1, limit: 2 } },
    parseAs: "stream",
  });
  assert.equal((await page.response.text()).trim().split("\n").length, 2);
  const { data: all } = await client.GET("/jobs");
  assert.ok(all?.jobs.some((job) => job.jobID === accepted.jobID));
  assert.equal((await client.DELETE("/jobs/{job_id}", { params: of })).data?.status, "dismissed");
}

async function problems() {
  const { data, error } = await client.POST("/fit", { body: { points: [[1, 2, 3]] } });
  assert.equal(data, undefined);
  assert.equal(error?.status, 422);
  assert.equal(error.errors[0]?.field, "points");
}

async function service() {
  assert.equal((await client.GET("/livez")).data?.status, "alive");
  assert.ok((await client.GET("/readyz")).data?.workers);
  assert.match((await client.GET("/version")).data?.primfit ?? "", /^\d+\./);
  assert.ok((await client.GET("/capabilities")).data?.kinds.includes("torus"));
  assert.match((await client.GET("/metrics", { parseAs: "text" })).data ?? "", /^primfit_workers_warm /m);
}

async function nothingIsLeftOut() {
  const { paths } = await (await fetch(`${url}/openapi.json`)).json();
  const all = Object.entries(paths).flatMap(([path, methods]) =>
    Object.keys(methods as object).map((method) => `${method} ${path}`),
  );
  assert.deepEqual(all.filter((operation) => !driven.has(operation)), [], "operations that drive.ts does not call");
  console.log(`${all.length} operations driven`);
}
