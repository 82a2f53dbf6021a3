let components = {}, schemas = {};

/** A new element; text between `backquotes` becomes code. */
function make(tag, text, parent) {
  const node = document.createElement(tag);
  (text || "").split("`").forEach((part, i) => {
    if (i % 2) node.append(Object.assign(document.createElement("code"), { textContent: part }));
    else node.append(part);
  });
  if (parent) parent.append(node);
  return node;
}

function makePlain(tag, text, parent) {
  const node = make(tag, "", parent);
  node.textContent = text;
  return node;
}

/** JSON as one reads it: an array or object that fits on a line stays on one. */
function pretty(value, indent = "") {
  const line = JSON.stringify(value);
  if (value === null || typeof value !== "object" || line.length + indent.length < 90) return line;
  const inner = indent + "  ", list = Array.isArray(value);
  const items = Object.entries(value).map(([name, item]) =>
    inner + (list ? "" : JSON.stringify(name) + ": ") + pretty(item, inner));
  return (list ? "[\n" : "{\n") + items.join(",\n") + "\n" + indent + (list ? "]" : "}");
}
const shown = value => typeof value === "string" ? value : pretty(value);
const nameOf = schema => schema.$ref.split("/").pop();
const resolved = node => node && node.$ref ? components[node.$ref.split("/")[2]][nameOf(node)] : node;

function typeName(schema) {
  if (schema.$ref) return (schemas[nameOf(schema)] || {}).enum ? typeName(schemas[nameOf(schema)]) : nameOf(schema);
  const choices = schema.anyOf || schema.oneOf;
  if (choices) return choices.map(typeName).join(" | ");
  if (schema.const !== undefined) return schema.const;
  if (schema.enum) return schema.enum.join(" | ");
  return schema.type === "array" ? `list of ${typeName(schema.items || {})}` : schema.type || "any";
}

function addRows(parent, rows, classes = []) {
  const table = make("table", "", parent);
  rows.forEach((row, i) => {
    const line = make("tr", "", table);
    line.className = classes[i] || "";
    for (const cell of row) make("td", cell, line);
  });
}

const digits = number => typeof number === "number" ? String(Number(number.toPrecision(6))) : "";
