/** Send an example, what was typed, or files, with options, and show what comes back. */
function addTrial(parent, method, path, operation) {
  const box = make("div", "", parent);
  box.className = "trial";
  const body = operation.requestBody && operation.requestBody.content;
  const takeBody = body ? addInputs(box, body) : () => ({});
  const takeParameters = addParameters(box, (operation.parameters || []).map(resolved));
  const line = make("div", "", box);
  line.className = "row";
  const send = make("button", `Send ${method.toUpperCase()} ${path}`, line), note = make("span", "", line);
  send.className = "send";
  note.className = "quiet";
  note.setAttribute("role", "status");
  const answer = make("div", "", box);
  send.onclick = async () => {
    send.disabled = true;
    note.textContent = "waiting";
    answer.replaceChildren();
    try {
      const begun = performance.now(), { query, headers } = takeParameters(), { body, type } = takeBody();
      const sent = { ...keyHeader(), ...headers, ...(type && { "Content-Type": type }) };
      const response = await fetch(`.${path}${query}`, { method, body, headers: sent });
      const reply = await response.clone().blob();
      note.textContent = `${response.status} after ${Math.round(performance.now() - begun)} ms, request ${response.headers.get("X-Request-Id")}`;
      const points = typeof body === "string" ? pointsIn(body) : null;
      if (reply.type.startsWith("application/zip")) await addArchive(answer, response, points);
      else addAnswer(answer, await reply.text(), points);
    } catch (error) {
      note.textContent = `no answer: ${error.message}`;
    }
    send.disabled = false;
  };
}

/** A body to edit, filled from the examples, and files in its place; returns what makes the body of them. */
function addInputs(box, content) {
  const examples = Object.entries((content["application/json"] || {}).examples || {});
  const form = resolved((content["multipart/form-data"] || {}).schema);
  const parts = Object.entries(form ? form.properties : {});
  const [part, files] = parts.find(([, schema]) => (schema.items || schema).format === "binary") || [];
  make("p", `Send this body${part ? ", or choose a file or drop it here" : ""}. Nothing leaves this service.`, box);
  const area = make("textarea", "", box);
  area.setAttribute("aria-label", "body");
  const fill = value => { area.value = JSON.stringify(value); };
  if (examples.length) fill(examples[0][1].value);
  const line = make("div", "", box);
  line.className = "row";
  if (examples.length > 1)
    for (const [name, example] of examples) {
      const choose = makePlain("button", name.replaceAll("_", " "), line);
      choose.className = "other";
      choose.onclick = () => { fill(example.value); file.value = ""; };
    }
  const file = make("input", "", line);
  Object.assign(file, { type: "file", multiple: Boolean(files && files.items), hidden: !part });
  file.setAttribute("aria-label", "file");
  const options = addField(line, "options of a file, as JSON", '{"kinds": ["cylinder", "cone"]}');
  options.parentNode.hidden = !(form && form.properties.options);
  acceptDrops(box, file);
  return () => {
    if (!file.files.length) return { body: area.value, type: "application/json" };
    const data = new FormData();
    for (const chosen of file.files) data.append(part, chosen);
    if (options.value.trim()) data.append("options", new Blob([options.value], { type: "application/json" }));
    return { body: data };
  };
}

function acceptDrops(box, file) {
  const over = on => event => { event.preventDefault(); box.classList.toggle("over", on); };
  box.ondragover = over(true);
  box.ondragleave = over(false);
  box.ondrop = event => { over(false)(event); file.files = event.dataTransfer.files; };
}

/** The key that a service may ask for; it is kept in this page only. */
function addKey(parent, schemes) {
  const scheme = Object.values(schemes || {}).find(scheme => scheme.type === "apiKey" && scheme.in === "header");
  if (!scheme) return;
  const field = addField(parent, "API key, where the service asks for one", scheme.name);
  field.type = "password";
  keyHeader = () => field.value ? { [scheme.name]: field.value } : {};
}
let keyHeader = () => ({});
