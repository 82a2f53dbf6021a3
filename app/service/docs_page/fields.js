/** A field with its name above it. */
function addField(parent, title, placeholder, tag = "input") {
  const label = make("label", "", parent);
  make("span", title, label).className = "name";
  const field = make(tag, "", label);
  if (tag === "input") Object.assign(field, { type: "text", placeholder: placeholder || "" });
  return field;
}

/** A field for each parameter of an operation, those that are needed first; returns what reads them. */
function addParameters(box, parameters) {
  const needed = parameters.filter(parameter => parameter.required);
  const others = parameters.filter(parameter => !parameter.required);
  const readers = needed.map(parameter => addParameter(box, parameter));
  if (others.length) {
    const details = make("details", "", box), grid = make("div", "", details);
    details.prepend(make("summary", `Options: ${others.map(parameter => `\`${parameter.name}\``).join(", ")}`));
    grid.className = "grid";
    readers.push(...others.map(parameter => addParameter(grid, parameter)));
  }
  return () => {
    const query = new URLSearchParams(), headers = {};
    readers.forEach((read, i) => {
      const { name, in: place, explode } = [...needed, ...others][i], values = read();
      if (place === "header") { if (values.length) headers[name] = values[0]; }
      else if (explode === false) { if (values.length) query.append(name, values.join(",")); }
      else for (const value of values) query.append(name, value);
    });
    const text = query.toString();
    return { query: text && `?${text}`, headers };
  };
}

/** The fields of one parameter; returns what reads its values, none where nothing is given. */
function addParameter(parent, parameter) {
  const schema = plainSchema(parameter.schema), items = plainSchema(schema.items);
  if (schema.type === "array" && items.enum) return addChoices(parent, parameter, items.enum, !schema.minItems);
  const choices = schema.enum || (schema.type === "boolean" ? [true, false] : undefined);
  const field = addField(parent, `\`${parameter.name}\``, schema.type, choices ? "select" : "input");
  field.title = parameter.description || "";
  for (const choice of choices ? ["", ...choices] : []) makePlain("option", String(choice), field);
  return () => field.value.trim() ? [field.value.trim()] : [];
}

/** Boxes to tick; a list that may be empty has one for that. */
function addChoices(parent, parameter, choices, mayBeEmpty) {
  const group = make("fieldset", "", parent);
  make("legend", `\`${parameter.name}\``, group);
  group.title = parameter.description || "";
  const values = mayBeEmpty && !parameter.required ? { "": "none of them" } : {};
  const boxes = [...choices, ...Object.keys(values)].map(choice => {
    const label = make("label", "", group), box = make("input", "", label);
    Object.assign(box, { type: "checkbox", value: choice, checked: parameter.required && (parameter.example || []).includes(choice) });
    label.append(` ${values[choice] || choice}`);
    return box;
  });
  return () => boxes.filter(box => box.checked).map(box => box.value);
}

/** A schema without its reference, and without null where it may be that, too. */
function plainSchema(schema) {
  const found = schema && schema.$ref ? schemas[nameOf(schema)] : schema || {};
  const choice = (found.anyOf || []).find(option => option.type !== "null");
  return choice ? plainSchema(choice) : found;
}
