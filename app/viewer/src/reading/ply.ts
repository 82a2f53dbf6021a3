import { Cloud } from "../cloud";
import { Labelling, cloudOf, columnsOf, type Columns } from "./table";

interface Property {
  readonly name: string;
  readonly type: string;
}

export interface Vertices {
  readonly n: number;
  readonly format: string;
  readonly properties: readonly Property[];
  /** Where the first vertex begins. */
  readonly start: number;
}

const SIZES: Record<string, number> = {
  char: 1, int8: 1, uchar: 1, uint8: 1,
  short: 2, int16: 2, ushort: 2, uint16: 2,
  int: 4, int32: 4, uint: 4, uint32: 4, float: 4, float32: 4,
  double: 8, float64: 8,
}; // prettier-ignore

type Get = (view: DataView, at: number, little: boolean) => number;
const GETS: Record<string, Get> = {
  char: (view, at) => view.getInt8(at),
  uchar: (view, at) => view.getUint8(at),
  short: (view, at, little) => view.getInt16(at, little),
  ushort: (view, at, little) => view.getUint16(at, little),
  int: (view, at, little) => view.getInt32(at, little),
  uint: (view, at, little) => view.getUint32(at, little),
  float: (view, at, little) => view.getFloat32(at, little),
  double: (view, at, little) => view.getFloat64(at, little),
};
const OLD_NAMES: Record<string, string> = {
  int8: "char", uint8: "uchar", int16: "short", uint16: "ushort",
  int32: "int", uint32: "uint", float32: "float", float64: "double",
}; // prettier-ignore

/** The header of a PLY whose first element is its vertices; null for any other. */
export function headerOf(bytes: Uint8Array): Vertices | null {
  const head = new TextDecoder("latin1").decode(bytes.subarray(0, 64 * 1024));
  const end = /^ply\r?\n[\s\S]*?\nend_header\r?\n/.exec(head);
  if (end === null) return null;
  const lines = end[0].split(/\r?\n/);
  const format = lines.find((line) => line.startsWith("format"))?.split(/\s+/)[1] ?? "";
  const at = lines.findIndex((line) => line.startsWith("element"));
  const [, name, count] = lines[at]?.split(/\s+/) ?? [];
  if (name !== "vertex") return null;
  const properties: Property[] = [];
  for (const line of lines.slice(at + 1)) {
    const [word, type, called] = line.split(/\s+/);
    if (word === "element" || word === "end_header") break;
    if (word === "property") properties.push({ type: OLD_NAMES[type] ?? type, name: called });
  }
  const known = properties.every(({ type }) => type in GETS);
  return known ? { n: Number(count), format, properties, start: end[0].length } : null;
}

/** One property of all vertices of a binary PLY (N). */
export function columnOf(bytes: Uint8Array, { n, format, properties, start }: Vertices, column: number): Float64Array {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const little = format === "binary_little_endian";
  const offsets = [0];
  for (const { type } of properties) offsets.push(offsets.at(-1)! + SIZES[type]);
  const stride = offsets.at(-1)!;
  const get = GETS[properties[column].type];
  const first = start + offsets[column];
  const values = new Float64Array(n);
  for (let i = 0; i < n; i++) values[i] = get(view, first + i * stride, little);
  return values;
}

/** Whether the vertices have labels, by the header alone. */
export function hasLabels(bytes: Uint8Array): boolean {
  const vertices = headerOf(bytes);
  return (vertices && columnsFor(vertices))?.label != null;
}

const columnsFor = ({ properties }: Vertices): Columns | null => columnsOf(properties.map(({ name }) => name));

export function readPly(bytes: Uint8Array): Cloud | null {
  const vertices = headerOf(bytes);
  const columns = vertices && columnsFor(vertices);
  if (!vertices || !columns) return null;
  return vertices.format === "ascii" ? ofText(bytes, vertices, columns) : ofBinary(bytes, vertices, columns);
}

function ofBinary(bytes: Uint8Array, vertices: Vertices, { xyz, label }: Columns): Cloud {
  const values = new Float64Array(3 * vertices.n);
  for (let k = 0; k < 3; k++) {
    const column = columnOf(bytes, vertices, xyz[k]);
    for (let i = 0; i < vertices.n; i++) values[3 * i + k] = column[i];
  }
  if (label === null) return cloudOf(values, null);
  const labelling = new Labelling();
  for (const each of columnOf(bytes, vertices, label)) labelling.add(each);
  return cloudOf(values, labelling.finished());
}

function ofText(bytes: Uint8Array, { n, start }: Vertices, { xyz, label }: Columns): Cloud {
  const cells = new TextDecoder().decode(bytes.subarray(start)).split("\n", n);
  const values = new Float64Array(3 * cells.length);
  const labelling = new Labelling();
  cells.forEach((line, i) => {
    const row = line.trim().split(/\s+/);
    for (let k = 0; k < 3; k++) values[3 * i + k] = Number(row[xyz[k]] ?? NaN);
    if (label !== null) labelling.add(Number(row[label]));
  });
  return cloudOf(values, label === null ? null : labelling.finished());
}
