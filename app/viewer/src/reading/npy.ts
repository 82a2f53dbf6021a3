import type { Cloud } from "../cloud";
import { cloudOf } from "./table";

export const MAGIC = "\x93NUMPY";

/** An array of floats or integers, behind `MAGIC`, whose rows begin with x, y, z; null for others, as of records. */
export function readNpy(bytes: Uint8Array): Cloud | null {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const wide = bytes[6] > 1;
  const start = (wide ? 12 : 10) + (wide ? view.getUint32(8, true) : view.getUint16(8, true));
  const head = new TextDecoder().decode(bytes.subarray(10, start));
  const type = /'descr': '([<|])([fiu])(\d)'/.exec(head);
  const shape = /'shape': \((\d+), (\d+)\)/.exec(head);
  if (!type || !shape || /'fortran_order': True/.test(head) || Number(shape[2]) < 3) return null;
  const [n, width] = [Number(shape[1]), Number(shape[2])];
  const numbers = array(type[2] + type[3], bytes, start, n * width);
  if (numbers === null) return null;
  if (numbers instanceof Float64Array && width === 3) return cloudOf(numbers, null);
  const values = new Float64Array(3 * n);
  for (let i = 0; i < n; i++) for (let k = 0; k < 3; k++) values[3 * i + k] = Number(numbers[i * width + k]);
  return cloudOf(values, null);
}

type Kind = (new (buffer: ArrayBuffer, start: number, n: number) => ArrayLike<number>) & { BYTES_PER_ELEMENT: number };

/** The numbers where they lie, or a copy of them where they lie askew; null for other types, or too few. */
function array(type: string, bytes: Uint8Array, start: number, n: number): ArrayLike<number> | null {
  const kinds: Record<string, Kind> = {
    f4: Float32Array,
    f8: Float64Array,
    i2: Int16Array,
    i4: Int32Array,
    u1: Uint8Array,
    u2: Uint16Array,
    u4: Uint32Array,
  };
  const Kind = kinds[type];
  if (!Kind || bytes.length - start < n * Kind.BYTES_PER_ELEMENT) return null;
  const buffer = bytes.buffer as ArrayBuffer;
  const at = bytes.byteOffset + start;
  return at % Kind.BYTES_PER_ELEMENT === 0 ? new Kind(buffer, at, n) : new Kind(buffer.slice(at), 0, n);
}
