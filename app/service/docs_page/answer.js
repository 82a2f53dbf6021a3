const MOST_SHOWN = 20;

/** What was found in words, a picture and tables, and the answer itself; one a line where there are several. */
function addAnswer(parent, text, points) {
  const answers = parsed(text);
  const found = (answers || []).map(answer => answer && answer.answer ? { id: answer.id, ...answer.answer } : answer)
    .filter(answer => answer && answer.attempts);
  for (const answer of found.slice(0, MOST_SHOWN)) addFound(parent, answer, points);
  if (found.length > MOST_SHOWN) makePlain("p", `The first ${MOST_SHOWN} of ${found.length} answers are shown.`, parent);
  const whole = found.length ? make("details", "", parent) : parent;
  if (found.length) make("summary", "The whole answer", whole);
  makePlain("pre", answers ? answers.map(answer => pretty(answer)).join("\n") : text, whole);
}

function parsed(text) {
  try { return [JSON.parse(text)]; } catch { /* not one document: lines of JSON, or text */ }
  try { return text.trim().split("\n").map(line => JSON.parse(line)); } catch { return null; }
}

const UNITS = { axis: "", normal: "", half_angle: " rad" };

/** The parameters, lengths in a unit; empty where it is not known. */
const parameterRows = ({ kind, ...parameters }, unit) =>
  Object.entries(parameters).map(([name, value]) =>
    [`\`${name}\``, [value].flat().map(digits).join(", ") + (UNITS[name] ?? unit)]);

/** What to know of the points and of the parameters. */
const warningsOf = ({ warnings, uncertainty }) =>
  [...(warnings || []), ...((uncertainty || {}).warnings || []).map(warning => warning.message)];

function addFound(parent, answer, points) {
  const box = make("div", "", parent), line = make("p", "", box);
  box.className = "found";
  if (answer.id) line.append(`${answer.id}: `);
  makePlain("strong", answer.primitive ? `${answer.primitive.kind}, ${answer.status}` : answer.status, line);
  line.append(` ${answer.message}`);
  const unit = answer.receipt.unit ? ` ${answer.receipt.unit}` : "", asked = answer.conformance;
  if (asked && asked.verdict) makePlain("p", `Tolerances: ${asked.verdict}.`, box);
  for (const warning of warningsOf(answer)) makePlain("p", warning, box);
  addPicture(box, answer, points && points.length === answer.receipt.n_points ? points : null);
  const rows = parameterRows(answer.primitive || {}, unit);
  if (answer.error) rows.push(["rms distance", digits(answer.error.rms) + unit]);
  if (answer.noise) rows.push(["scale of the noise", digits(answer.noise.scale) + unit]);
  addRows(box, rows);
  for (const { error, extents, uncertainty, evidence, ...other } of answer.alternatives) {
    make("h3", `Or a ${other.kind}`, box);
    addRows(box, [...parameterRows(other, unit), ["rms distance", digits(error.rms) + unit]]);
  }
  make("h3", "What was tried", box);
  const tried = answer.attempts.map(attempt =>
    [attempt.kind, attempt.outcome, attempt.probability === null ? "" : `p\u00a0=\u00a0${attempt.probability.toFixed(3)}`, attempt.reason]);
  addRows(box, tried, answer.attempts.map(attempt => attempt.outcome));
}

/** A ZIP and its files to keep, the answer among them, and the report to look at. */
async function addArchive(parent, response, points) {
  const archive = await response.blob(), list = make("p", "", parent);
  list.className = "files";
  addDownload(list, nameOfFile(response), archive);
  for (const [name, content] of await filesIn(await archive.arrayBuffer())) {
    addDownload(list, name, content);
    if (name === "answer.json") addAnswer(parent, await content.text(), points);
    if (name === "report.html") addReport(parent, await content.text());
  }
}

function nameOfFile(response) {
  const header = response.headers.get("Content-Disposition") || "";
  const [, encoded] = /filename\*=UTF-8''([^;]+)/.exec(header) || [], [, plain] = /filename="([^"]*)"/.exec(header) || [];
  return encoded ? decodeURIComponent(encoded) : plain || "primfit.zip";
}

function addDownload(parent, name, content) {
  const link = makePlain("a", name, parent);
  Object.assign(link, { href: URL.createObjectURL(content), download: name });
  parent.append(` ${content.size.toLocaleString("en")} bytes `);
}

function addReport(parent, document) {
  const frame = make("iframe", "", parent);
  frame.setAttribute("sandbox", "");
  Object.assign(frame, { title: "report", srcdoc: document });
}
