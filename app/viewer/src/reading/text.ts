import type { Cloud } from "../cloud";
import { Labelling, cloudOf, columnsOf, type Columns } from "./table";

const COMMENT = /^\s*(#|\/\/)\s*/;
const NUMBER = /^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*$/;

/** Rows of columns between commas, semicolons, tabs or spaces; null where that is not what it is. */
export function readText(text: string): Cloud | null {
  const lines = text.split(/\r?\n/);
  const first = lines.findIndex((line) => isRow(line));
  if (first < 0) return null;
  const cut = cutter(lines[first]);
  const names = lines
    .slice(0, first)
    .map((line) => columnsOf(cut(line.replace(COMMENT, "")).length > 2 ? cut(line.replace(COMMENT, "")) : []))
    .filter((found) => found !== null)
    .at(-1);
  const columns: Columns = names ?? { xyz: [0, 1, 2], label: null };
  const { xyz, label } = columns;
  const values = new Float64Array(3 * (lines.length - first));
  const labelling = new Labelling();
  let n = 0;
  for (const line of lines.slice(first)) {
    if (line === "" || COMMENT.test(line)) continue;
    const cells = cut(line);
    for (let k = 0; k < 3; k++) values[3 * n + k] = Number(cells[xyz[k]]?.trim() || NaN);
    if (label !== null) labelling.add(worded((cells[label] ?? "").trim()));
    n++;
  }
  return cloudOf(values.slice(0, 3 * n), label === null ? null : labelling.finished());
}

const isRow = (line: string): boolean => {
  if (COMMENT.test(line)) return false;
  const cells = cutter(line)(line);
  return cells.length >= 3 && cells.filter((cell) => NUMBER.test(cell)).length >= 3;
};

function cutter(line: string): (line: string) => string[] {
  const by = line.includes(";") ? ";" : line.includes(",") ? "," : null;
  if (by === null) return (each) => each.trim().split(/\s+/);
  return (each) => (each.includes('"') ? each.split(by).map(unquoted) : each.split(by));
}

const unquoted = (cell: string): string => cell.trim().replace(/^"|"$/g, "");

const worded = (cell: string): string | number => (/^-?\d+(\.0*)?$/.test(cell) ? Number(cell) : cell);
