// SPDX-License-Identifier: Apache-2.0
// A browser for tests, and pictures as pixels. Tests are skipped where there is no Chromium ($CHROMIUM,
// /usr/bin/chromium-headless-shell or /usr/bin/chromium).
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { inflateSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));
const chromium = [process.env.CHROMIUM, "/usr/bin/chromium-headless-shell", "/usr/bin/chromium"].find((file) => file && existsSync(file));
const templateFile = process.env.QUENCH_PAGE ?? join(here, "..", "dist", "page.html");
const skip = !chromium ? "no Chromium" : !existsSync(templateFile) ? `no ${templateFile}: run node build.mjs first` : false;
/// Only the picture of the page goes through the software renderer, not what lies beside it; pages share a process.
const CHEAP = ["--disable-gpu-compositing", "--renderer-process-limit=1"];
const FLAGS = ["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...CHEAP];

/// Pixels of pictures per pixel of the page, in which places are given: a quarter of the pixels are drawn, but in the full run.
export const SCALE = process.env.QUENCH_TEST_FULL === "1" ? 1 : 0.5;

/// Pixels of an 8-bit RGB or RGBA PNG, as rows of numbers.
export function pixelsOf(png) {
  const width = png.readUInt32BE(16), height = png.readUInt32BE(20), channels = png[25] === 6 ? 4 : 3;
  const parts = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) if (png.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
  const raw = inflateSync(Buffer.concat(parts)), row = width * channels, out = Buffer.alloc(row * height);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (row + 1)];
    for (let x = 0; x < row; ++x) {
      const left = x >= channels ? out[y * row + x - channels] : 0, up = y > 0 ? out[(y - 1) * row + x] : 0, corner = x >= channels && y > 0 ? out[(y - 1) * row + x - channels] : 0;
      const p = left + up - corner, a = Math.abs(p - left), b = Math.abs(p - up), c = Math.abs(p - corner);
      const guess = [0, left, up, (left + up) >> 1, a <= b && a <= c ? left : b <= c ? up : corner][filter];
      out[y * row + x] = raw[y * (row + 1) + 1 + x] + guess;
    }
  }
  return { width, height, channels, data: out };
}

/// The colour (red, green, blue) of a picture at a place of the page.
export function colourIn({ data, width, channels }, x, y) {
  const at = channels * (Math.floor(SCALE * y) * width + Math.floor(SCALE * x));
  return [data[at], data[at + 1], data[at + 2]];
}

export function coloursIn(png) {
  const { data, channels } = pixelsOf(png), seen = new Map();
  for (let i = 0; i < data.length; i += channels) {
    const key = ((data[i] >> 4) << 8) | ((data[i + 1] >> 4) << 4) | (data[i + 2] >> 4);
    seen.set(key, (seen.get(key) ?? 0) + 1);
  }
  return seen;
}

/// For the tests of a file: `it` is skipped test by test, so that the summary counts what was skipped; `template` is the
/// empty page.
export function browserOf() {
  let context, folder, serial = 0;
  before(async () => {
    if (skip) return;
    const { chromium: launcher } = await import("playwright-core");
    folder = mkdtempSync(join(tmpdir(), "quench-page-"));
    context = await launcher.launchPersistentContext(join(folder, "profile"), { executablePath: chromium, headless: true, args: FLAGS, viewport: { width: 1000, height: 700 }, deviceScaleFactor: SCALE, colorScheme: "light", acceptDownloads: true });
  });
  after(async () => {
    await context?.close();
    if (folder) rmSync(folder, { recursive: true, force: true });
  });

  /// Opens a page; its errors and console output are in `complaints`.
  async function open(html, hash = "") {
    const file = join(folder, `${++serial}.html`);
    writeFileSync(file, html);
    const page = await context.newPage(), complaints = [];
    page.on("console", (m) => ["error", "warning"].includes(m.type()) && !/GPU stall|software WebGL|GL Driver Message/.test(m.text()) && complaints.push(m.text()));
    page.on("pageerror", (e) => complaints.push(e.message));
    page.on("request", (r) => !/^(file|data|blob):/.test(r.url()) && complaints.push(`request to ${r.url()}`));
    await page.goto(pathToFileURL(file).href + (hash && `#${hash}`));
    await page.waitForFunction("window.quench && (window.quench.ready || window.quench.error)", null, { timeout: 60000 });
    return { page, complaints };
  }
  const settled = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  return { it: (name, body) => test(name, { skip }, body), open, settled, template: skip ? "" : readFileSync(templateFile, "utf8") };
}
