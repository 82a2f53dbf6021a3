/** Reads files beside the page: what it cannot read, the service does. */

import { expose, transfer } from "comlink";
import type { Cloud, Labels } from "../cloud";
import { readNpy } from "./npy";
import { readPly } from "./ply";
import { readText } from "./text";

export interface Parts {
  readonly xyz: Float64Array;
  readonly labels: Labels | null;
}

/** First bytes of formats that the service reads by their own rules. */
const OTHERS = ["LASF", "ASTM-E57", "PK", "glTF", "\x1f\x8b", "(\xb5/\xfd", "solid", "{", "[", "# .PCD", "VERSION"];

async function read(file: Blob): Promise<Parts | null> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const start = new TextDecoder("latin1").decode(bytes.subarray(0, 16));
  const cloud = OTHERS.some((each) => start.startsWith(each)) ? null : parsed(start, bytes);
  if (cloud === null || cloud.n === 0) return null;
  return transfer({ xyz: cloud.xyz, labels: cloud.labels }, [cloud.xyz.buffer as ArrayBuffer]);
}

function parsed(start: string, bytes: Uint8Array): Cloud | null {
  if (start.startsWith("ply")) return readPly(bytes);
  if (start.startsWith("\x93NUMPY")) return readNpy(bytes);
  return bytes.subarray(0, 1024).includes(0) ? null : readText(new TextDecoder().decode(bytes));
}

export const reader = { read };
export type Reader = typeof reader;
expose(reader);
