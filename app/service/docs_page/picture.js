const plus = (a, b) => a.map((x, i) => x + b[i]);
const times = (a, factor) => a.map(x => x * factor);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const unit = a => times(a, 1 / Math.hypot(...a));
const across = axis => unit(cross(axis, Math.abs(axis[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
const spread = (start, span, n) => Array.from({ length: n + 1 }, (_, i) => start + span * i / n);
const MOST_DRAWN = 4000;

/** The signed distance of a point from the surface, positive on the outer side. */
const DISTANCES = {
  plane: ({ normal, point }, p) => dot(plus(p, times(point, -1)), normal),
  sphere: ({ center, radius }, p) => Math.hypot(...plus(p, times(center, -1))) - radius,
  cylinder: ({ point, axis, radius }, p) => aroundAxis(p, point, axis)[0] - radius,
  cone: ({ apex, axis, half_angle }, p) => {
    const [out, up] = aroundAxis(p, apex, axis);
    return out * Math.cos(half_angle) - up * Math.sin(half_angle);
  },
  torus: ({ center, axis, major_radius, minor_radius }, p) => {
    const [out, up] = aroundAxis(p, center, axis);
    return Math.hypot(out - major_radius, up) - minor_radius;
  },
};

/** How far a point lies from an axis, and how high above its origin. */
function aroundAxis(p, origin, axis) {
  const from = plus(p, times(origin, -1)), up = dot(from, axis);
  return [Math.hypot(...plus(from, times(axis, -up))), up];
}

/** Lines on the surface within its extents, and where it is best looked at from; null of a kind that is not known. */
const SHAPES = {
  plane: ({ normal }, { concave_outline, length_direction }) => ({
    lines: concave_outline.flat().map(ring => [...ring, ring[0]]),
    front: plus(normal, times(length_direction, 0.5)), up: cross(normal, length_direction),
  }),
  cylinder: ({ axis, radius }, extents) => turned(extents.start, axis, extents, [[radius, 0], [radius, extents.length]]),
  cone: ({ apex, axis }, extents) =>
    turned(apex, axis, extents, [[extents.start_radius, extents.start_height], [extents.end_radius, extents.end_height]]),
  sphere: ({ center, radius }, { axis, start_half_angle, half_angle }) => {
    const profile = spread(start_half_angle, half_angle - start_half_angle, 24).map(a => [radius * Math.sin(a), radius * Math.cos(a)]);
    return turned(center, axis, { reference_direction: across(axis), start_angle: 0, span: 2 * Math.PI }, profile);
  },
  torus: ({ center, axis, major_radius, minor_radius }, extents) => turned(center, axis, extents,
    spread(extents.tube_start_angle, extents.tube_span, 32).map(a => [major_radius + minor_radius * Math.cos(a), minor_radius * Math.sin(a)])),
};

/** A profile of [distance from the axis, height], turned about an axis. */
function turned(origin, axis, { reference_direction, start_angle, span }, profile) {
  const other = cross(axis, reference_direction);
  const outward = angle => plus(times(reference_direction, Math.cos(angle)), times(other, Math.sin(angle)));
  const at = (angle, [out, up]) => plus(origin, plus(times(outward(angle), out), times(axis, up)));
  const rings = spread(0, profile.length - 1, profile.length > 2 ? 8 : 1).map(i => profile[Math.round(i)]);
  return {
    lines: [
      ...rings.map(place => spread(start_angle, span, 72).map(angle => at(angle, place))),
      ...spread(start_angle, span, 12).map(angle => profile.map(place => at(angle, place))),
    ],
    front: plus(outward(start_angle + span / 2), times(axis, 0.5)), up: axis,
  };
}

/** The surface that was found and the points that were sent, where they are known, as one looks at them. */
function addPicture(parent, { primitive, extents }, points) {
  const known = primitive && extents && SHAPES[primitive.kind];
  const { lines, front, up } = known ? known(primitive, extents) : { lines: [], front: [1, -1.5, 1], up: [0, 0, 1] };
  const step = Math.ceil((points || []).length / MOST_DRAWN), drawn = (points || []).filter((_, i) => i % step === 0);
  if (!lines.length && !drawn.length) return;
  const right = unit(cross(up, front)), upward = unit(cross(unit(front), right));
  const flat = p => [dot(p, right), -dot(p, upward)];
  const flatLines = lines.map(line => line.map(flat)), flatPoints = drawn.map(flat);
  const all = [...flatLines.flat(), ...flatPoints];
  const [low, high] = [Math.min, Math.max].map(pick => [0, 1].map(i => all.reduce((found, p) => pick(found, p[i]), all[0][i])));
  const scale = 440 / Math.max(high[0] - low[0], (high[1] - low[1]) * 1.4, 1e-300);
  const place = p => p.map((x, i) => ((x - low[i]) * scale + 10).toFixed(1));
  const svg = makeSvg("svg", { viewBox: `0 0 ${(high[0] - low[0]) * scale + 20} ${(high[1] - low[1]) * scale + 20}`, role: "img", preserveAspectRatio: "xMinYMid" });
  svg.setAttribute("aria-label", known ? `the ${primitive.kind} and the points` : "the points");
  for (const line of flatLines) svg.append(makeSvg("polyline", { points: line.map(p => place(p).join()).join(" ") }));
  const distance = primitive && DISTANCES[primitive.kind];
  flatPoints.forEach((p, i) => {
    const [cx, cy] = place(p), side = distance && (distance(primitive, drawn[i]) < 0 ? "inside" : "outside");
    svg.append(makeSvg("circle", { cx, cy, r: 1.6, class: side || "" }));
  });
  const figure = make("figure", "", parent);
  figure.append(svg);
  addCaption(figure, Boolean(known), drawn.length, (points || []).length, distance && primitive.kind);
}

function addCaption(figure, known, n_drawn, n_points, kind) {
  const caption = make("figcaption", "", figure);
  if (known) caption.append("The piece of the surface that the points cover. ");
  if (n_drawn < n_points) caption.append(`${n_drawn} of ${n_points} points. `);
  if (!n_drawn) caption.append("Points are drawn where they are sent in JSON, and in the report of an export. ");
  if (!n_drawn || !kind) return;
  const [below, above] = kind === "plane" ? ["behind the plane", "on the side of its normal"] : ["inside", "outside"];
  caption.append("Points ");
  makePlain("span", below, caption).className = "inside";
  caption.append(" and ");
  makePlain("span", above, caption).className = "outside";
  caption.append(".");
}

function makeSvg(tag, attributes) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
}

const NUMBERS = { float64: Float64Array, float32: Float32Array, int64: BigInt64Array, int32: Int32Array, int16: Int16Array };

/** The points of a request in JSON, as lists or as an encoded array; null where it is not such a request. */
function pointsIn(text) {
  try {
    const { points } = JSON.parse(text);
    if (Array.isArray(points)) return points;
    const bytes = Uint8Array.from(atob(points.base64), letter => letter.charCodeAt(0));
    const numbers = [...new NUMBERS[points.dtype](bytes.buffer)].map(Number);
    return Array.from({ length: numbers.length / 3 }, (_, i) => numbers.slice(3 * i, 3 * i + 3));
  } catch { return null; }
}
