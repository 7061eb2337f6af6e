// SPDX-License-Identifier: Apache-2.0
// Whether the installed packages are those of the lock file: node viewer_packages.mjs FOLDER. npm keeps a lock file of
// what it installed in node_modules. Packages for other platforms may be missing.
import { readFileSync } from "node:fs";

const folder = process.argv[2];
const packages = (file) => JSON.parse(readFileSync(`${folder}/${file}`, "utf8")).packages;
try {
  const wanted = packages("package-lock.json"), found = packages("node_modules/.package-lock.json");
  for (const [name, { version, optional }] of Object.entries(wanted)) {
    if (name === "" || (optional && !found[name])) continue;
    if (found[name]?.version !== version) process.exit(1);
  }
} catch {
  process.exit(1);
}
