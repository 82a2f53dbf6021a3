// Types of the service from its OpenAPI document: node generate.mjs [URL or FILE] writes schema.ts.
import { writeFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import openapiTS, { astToString } from "openapi-typescript";
import ts from "typescript";

const source = process.argv[2] ?? "http://127.0.0.1:8000/openapi.json";
const blob = ts.factory.createTypeReferenceNode("Blob");

const nodes = await openapiTS(/^https?:/.test(source) ? new URL(source) : pathToFileURL(source), {
  // A file is a Blob, in a form and as a body.
  transform: (schema) => (schema.format === "binary" ? blob : undefined),
  // What has a default may be left out of a request.
  defaultNonNullable: false,
});
await writeFile("schema.ts", astToString(nodes));
