/** Contents by media type; those that look alike share a line. */
function addContent(parent, title, content) {
  const alike = new Map();
  for (const [mediaType, media] of Object.entries(content || {})) {
    const key = JSON.stringify(media);
    alike.set(key, [...(alike.get(key) || []), mediaType]);
  }
  for (const [key, mediaTypes] of alike) {
    const media = JSON.parse(key), type = typeName(media.schema || {});
    const line = `${title}\`${mediaTypes.join("`, `")}\`` + (type === "string" ? "" : ` ${type}`);
    const examples = Object.entries(media.examples || {});
    if (!examples.length) { make("div", line, parent); continue; }
    const details = make("details", "", parent);
    make("summary", line, details);
    for (const [name, example] of examples) {
      make("div", name.replaceAll("_", " "), details).className = "quiet";
      makePlain("pre", shown(example.value), details);
    }
  }
}

function addOperation(parent, method, path, operation) {
  const heading = make("h2", "", parent);
  heading.id = operation.operationId;
  make("span", method.toUpperCase(), heading).className = "method";
  heading.append(" ");
  make("code", path, heading);
  makePlain("span", ` ${operation.summary}`, heading).className = "quiet";
  make("p", operation.description, parent);
  addTrial(parent, method, path, operation);
  if (operation.requestBody) {
    make("h3", "Body", parent);
    addContent(parent, "", operation.requestBody.content);
  }
  const parameters = (operation.parameters || []).map(resolved);
  for (const [place, title] of [["query", "Options, in the query or in the body"], ["header", "Headers"]]) {
    const rows = parameters.filter(p => p.in === place).map(p => [`\`${p.name}\``, typeName(p.schema), p.description]);
    if (rows.length) make("h3", title, parent);
    addRows(parent, rows);
  }
  make("h3", "Answers", parent);
  for (const [status, response] of Object.entries(operation.responses))
    addContent(parent, `${status} ${response.description}: `, response.content);
}

function addSchema(parent, name, schema) {
  const details = make("details", "", parent);
  make("summary", `\`${name}\` ${schema.description || ""}`, details);
  const required = schema.required || [], properties = Object.entries(schema.properties || {});
  if (!properties.length) makePlain("p", typeName(schema), details);
  addRows(details, properties.map(([field, type]) =>
    [`\`${field}\``, typeName(type) + (required.includes(field) ? "" : ", optional"), type.description || ""]));
}

/** A line of links for each tag. */
function addContents(parent, tags, operations) {
  for (const tag of [...tags, { name: undefined, description: "" }]) {
    const own = operations.filter(([, , operation]) => (operation.tags || [])[0] === tag.name);
    const line = make("p", "", own.length ? parent : undefined);
    for (const [path, method, operation] of own)
      Object.assign(makePlain("a", `${method.toUpperCase()} ${path}`, line), { href: "#" + operation.operationId, title: operation.summary });
    make("span", tag.description, line).className = "quiet";
  }
}

async function draw() {
  const api = await (await fetch("openapi.json")).json();
  components = api.components;
  schemas = components.schemas;
  const main = document.getElementById("main"), contents = document.getElementById("contents");
  make("span", `${api.info.description} `, document.getElementById("about"));
  const from = make("span", `Version ${api.info.version}, drawn from `, document.getElementById("about"));
  from.className = "quiet";
  makePlain("a", "openapi.json", from).href = "openapi.json";
  addKey(document.getElementById("key"), components.securitySchemes);
  const operations = Object.entries(api.paths).flatMap(([path, methods]) =>
    Object.entries(methods).map(([method, operation]) => [path, method, operation]));
  addContents(contents, api.tags || [], operations);
  for (const [path, method, operation] of operations) addOperation(main, method, path, operation);
  make("h2", "Schemas", main).id = "schemas";
  makePlain("a", "Schemas", make("p", "", contents)).href = "#schemas";
  for (const [name, schema] of Object.entries(schemas)) addSchema(main, name, schema);
}

draw().catch(error => { document.getElementById("about").textContent = `openapi.json cannot be shown: ${error.message}`; });
