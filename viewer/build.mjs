// SPDX-License-Identifier: Apache-2.0
// Bundles the page into one file: node build.mjs [OUTFILE]
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const outfile = process.argv[2] ?? join(here, "dist", "page.html");

const bundle = (entry, options = {}) =>
  build({
    entryPoints: [join(here, entry)],
    bundle: true,
    minify: true,
    write: false,
    target: "es2022",
    legalComments: "inline",
    charset: "ascii",
    ...options,
  }).then((result) => result.outputFiles[0].text.trim());

// Packed, as every page has it; page.html unpacks it into a classic script at the end of the body, which finds the data
// above it and works from file:// everywhere. Licences stay readable.
const script = await bundle("src/main.ts", { format: "iife" });
const licences = [...new Set(script.match(/\/\*[\s\S]*?\*\//g) ?? [])].filter((text) => /licen[cs]e|copyright/i.test(text)).join("\n").replaceAll("--", "- -");
const packed = gzipSync(script, { level: 9 }).toString("base64");
const style = (await bundle("src/ui/style.css")).replace(/<\/(style)/gi, "<\\/$1");
const template = readFileSync(join(here, "src", "page.html"), "utf8");
// Functions as replacements: "$&" in the bundle is no pattern.
const html = template.replace("/*STYLE*/", () => style).replace("LICENCES", () => licences).replace("SCRIPT", () => packed);

mkdirSync(dirname(outfile), { recursive: true });
writeFileSync(outfile, html);
