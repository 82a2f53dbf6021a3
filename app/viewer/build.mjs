/** Builds the page into the folder that is named, `built` by default. */

import { build } from "esbuild";
import { mkdir, copyFile, readFile, readdir, rm, writeFile } from "node:fs/promises";

const out = process.argv[2] ?? "built";
await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
const { metafile } = await build({
  entryPoints: { viewer: "src/page.tsx", reader: "src/reading/reader.ts" },
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  charset: "utf8",
  jsx: "automatic",
  jsxImportSource: "preact",
  legalComments: "none",
  metafile: true,
  outdir: out,
  // Else packages that are reached by a link are none of `node_modules`.
  preserveSymlinks: true,
});
await build({ entryPoints: ["src/viewer.css"], minify: true, outdir: out });
await copyFile("src/index.html", `${out}/index.html`);
await writeFile(`${out}/licenses.txt`, (await Promise.all(packages(metafile).map(licensed))).join("\n"));

/** The packages of which something is in the scripts. */
function packages({ inputs }) {
  const names = Object.keys(inputs).map((path) => /^node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(path)?.[1]);
  return [...new Set(names.filter((name) => name !== undefined))].sort();
}

/** What a package is, and its license in full. */
async function licensed(name) {
  const folder = `node_modules/${name}`;
  const { version, license } = JSON.parse(await readFile(`${folder}/package.json`, "utf8"));
  const file = (await readdir(folder)).find((each) => /^licen[cs]e/i.test(each));
  if (!file) throw new Error(`${name} comes without its license`);
  return `${name} ${version} (${license})\n\n${await readFile(`${folder}/${file}`, "utf8")}`;
}
