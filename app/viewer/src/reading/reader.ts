/** Reads files beside the page: what it cannot read, the service does. */

import { expose, transfer } from "comlink";
import type { Cloud, Labels } from "../cloud";
import { MAGIC, readNpy } from "./npy";
import { hasLabels, readPly } from "./ply";
import { readText } from "./text";

export interface Parts {
  readonly xyz: Float64Array;
  readonly labels: Labels | null;
}

/** First bytes of formats that the service reads by their own rules. */
const OTHERS = ["LASF", "ASTM-E57", "PK", "glTF", "\x1f\x8b", "(\xb5/\xfd", "solid", "{", "[", "# .PCD", "VERSION"];

/** Bytes at the beginning of a file that tell which columns it has. */
const HEAD = 64 * 1024;

/** Whether a file has a column of labels, by its beginning. */
async function isLabelled(file: Blob): Promise<boolean> {
  const bytes = new Uint8Array(await file.slice(0, HEAD).arrayBuffer());
  const start = startOf(bytes);
  if (start.startsWith("ply")) return hasLabels(bytes);
  return isOurs(start) && !start.startsWith(MAGIC) && !!parsed(start, bytes)?.labels;
}

async function read(file: Blob): Promise<Parts | null> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const start = startOf(bytes);
  const cloud = isOurs(start) ? parsed(start, bytes) : null;
  if (cloud === null || cloud.n === 0) return null;
  return transfer({ xyz: cloud.xyz, labels: cloud.labels }, [cloud.xyz.buffer as ArrayBuffer]);
}

/** The first bytes as letters of the same numbers; a decoder would take latin1 for windows-1252. */
const startOf = (bytes: Uint8Array): string => String.fromCharCode(...bytes.subarray(0, 16));
const isOurs = (start: string): boolean => !OTHERS.some((each) => start.startsWith(each));

function parsed(start: string, bytes: Uint8Array): Cloud | null {
  if (start.startsWith("ply")) return readPly(bytes);
  if (start.startsWith(MAGIC)) return readNpy(bytes);
  return bytes.subarray(0, 1024).includes(0) ? null : readText(new TextDecoder().decode(bytes));
}

export const reader = { isLabelled, read };
export type Reader = typeof reader;
expose(reader);
