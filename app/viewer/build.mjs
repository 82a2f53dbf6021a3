/** Builds the page into the folder that is named, `built` by default. */

import { build } from "esbuild";
import { mkdir, copyFile } from "node:fs/promises";

const out = process.argv[2] ?? "built";
const minified = { bundle: true, minify: true, format: "esm", target: "es2022", legalComments: "linked", charset: "utf8" };
await mkdir(out, { recursive: true });
await build({
  ...minified,
  entryPoints: { viewer: "src/page.tsx", reader: "src/reading/reader.ts" },
  jsx: "automatic",
  jsxImportSource: "preact",
  outdir: out,
});
await build({ entryPoints: ["src/viewer.css"], minify: true, outdir: out });
await copyFile("src/index.html", `${out}/index.html`);
