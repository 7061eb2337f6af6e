// SPDX-License-Identifier: Apache-2.0
// Sheets with their table, the surface by a measure, and medial meshes, in a browser.
import assert from "node:assert/strict";
import { describe } from "node:test";
import { browserOf, colourIn, pixelsOf } from "./browser.mjs";
import { boxShape, pageOf, simpleArrays, twoSheets } from "./fixture.mjs";

describe("pages of parts and measures", () => {
  const { it, open, settled, template } = browserOf();
  const thickness = [NaN, 0.5, 0.5, 0.5, 2, 2, 2, 2];
  const whole = (change = (arrays) => arrays) => {
    const shape = boxShape(), two = twoSheets();
    return pageOf(template, { title: "parts", ...shape.meta, columns: two.columns }, change({ ...two.arrays, ...simpleArrays(), ...shape.arrays, "shape/point/thickness": ["f32", 1, thickness] }));
  };
  const set = async (page, change) => {
    await page.evaluate((c) => window.quench.set(c), change);
    await settled(page);
  };
  const state = (page, ...keys) => page.evaluate((k) => k.map((key) => window.quench.state[key]), keys);
  const rows = (page) => page.$$eval(".branches .branch-rows .branch-row", (all) => all.map((row) => [...row.children].map((cell) => cell.textContent)));
  // Seen along -z, 700 pixels for 4 units around (2, 1.5), ten below the middle.
  const top = `camera=2,1.5,${1 + 2 / Math.tan((15 * Math.PI) / 180)},2,1.5,1,0,1,0`;
  const pixel = (x, y) => [Math.round(500 + ((x - 2) * 700) / 4), Math.round(360 - ((y - 1.5) * 700) / 4)];
  const coloursAt = async (page, ...places) => {
    const picture = pixelsOf(await page.screenshot());
    return places.map(([x, y]) => colourIn(picture, ...pixel(x, y)));
  };
  const colourAt = async (page, x, y) => (await coloursAt(page, [x, y]))[0];
  const bare = `${top}&ui=0&caption=0&orthographic=1`;

  it("sheets: table, sorting, picking by row and by click, CSV", async () => {
    const { page, complaints } = await open(whole(), `${top}&shape=0`);
    assert.match(await page.textContent(".to-table"), /Table of 1 branch and 2 sheets/);
    await set(page, { table: true, list: "sheets" });
    assert.deepEqual(await rows(page), [["1", "4", "0.8", "∞", "0"], ["0", "2", "0.55", "–", "1"]]); // by area
    assert.match(await page.textContent(".branch-head"), /area \(mm²\).*mean thickness \(mm\)/);
    await page.click('.branch-row[data-branch="0"]');
    assert.deepEqual(await state(page, "sheet", "branch"), [0, -1]);
    await settled(page);
    assert.match(await page.textContent(".chosen-sheet"), /Sheet 0.*area\s*2 mm².*mean thickness\s*0.55 mm/);
    assert.equal(await page.evaluate("window.quench.branches()"), "sheet,area,mean_thickness,max_erosion,neighbours\n1,4,0.8,inf,0\n0,2,0.55,,1\n");
    await page.click(".branch-tabs button:first-child");
    assert.deepEqual(await state(page, "list"), ["branches"]);
    await page.keyboard.press("Escape");
    assert.deepEqual(await state(page, "sheet"), [-1]);
    await set(page, { table: false, ui: false, caption: false, orthographic: true });
    await page.mouse.click(...pixel(1, 2));
    assert.deepEqual(await state(page, "sheet", "list", "branch"), [1, "sheets", -1]);
    await page.mouse.click(...pixel(3.5, 1)); // the branch
    assert.deepEqual(await state(page, "sheet", "list", "branch"), [-1, "branches", 0]);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("a bar of colours only where something has them", async () => {
    const { page, complaints } = await open(whole(), `${top}&shape=0&color=radius`);
    const shown = () => page.isVisible(".colour-bar >> nth=0");
    assert.equal(await shown(), true);
    await set(page, { sheets: false });
    assert.equal(await shown(), false); // curves have a colour of their own
    await set(page, { curvesByMeasure: true });
    assert.equal(await shown(), true);
    await set(page, { curves: false });
    assert.equal(await shown(), false);
    await set(page, { balls: true });
    assert.equal(await shown(), true);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("sheets have colours of their own and names, or those of a column; the picked one stands out", async () => {
    const { page, complaints } = await open(whole(), `${bare}&shape=0&color=sheet`);
    await settled(page);
    const hue = ([r, g, b]) => (b > r + 20 ? "blue" : r > b + 40 ? "warm" : "other");
    const [larger, before] = await coloursAt(page, [1, 2], [1, 0.5]);
    assert.deepEqual([hue(larger), hue(before)], ["blue", "warm"]); // the larger is the first
    const light = (c) => c[0] + c[1] + c[2];
    await set(page, { sheet: 1 });
    assert.ok(light(await colourAt(page, 1, 0.5)) > light(before) + 60); // the other one fades
    await set(page, { sheet: -1, color: "sheets/mean_thickness" });
    assert.equal(hue(await colourAt(page, 1, 2)), "warm"); // the end of the map
    await set(page, { ui: true });
    assert.match(await page.textContent(".colour-bar"), /mean thickness of the sheet \(mm\)/);
    await set(page, { color: "sheet" });
    assert.equal(await page.textContent(".colour-title"), "sheet");
    await set(page, { color: "sheets/sheet" });
    assert.equal((await state(page, "color"))[0], "erosion_thickness"); // numbers are no measure
    await set(page, { color: "sheets/max_erosion" });
    assert.match(await page.textContent(".colour-bar"), /infinite/);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("the surface by thickness: opaque it hides the axis and tells a click; paler it does not", async () => {
    const { page, complaints } = await open(whole(), bare);
    await settled(page);
    const glass = await colourAt(page, 1, 0.5);
    await set(page, { surface: "thickness" });
    assert.deepEqual(await state(page, "shape", "shapeOpacity"), [true, 1]);
    const [thin, thick, middle] = await coloursAt(page, [0.1, 0.2], [3.85, 0.2], [1, 0.5]);
    assert.ok(thick[0] > thin[0] + 60 && thick[1] > thin[1] + 60, `${thin} ${thick}`); // from purple to yellow
    assert.notDeepEqual(middle, glass);
    await page.mouse.click(...pixel(1, 0.5));
    await settled(page);
    await set(page, { ui: true });
    assert.match(await page.textContent(".picked"), /On the surface.*thickness\s*(0\.8|0\.9)\d* mm/);
    assert.match(await page.textContent(".bars"), /thickness \(mm\).*no value here/);
    assert.doesNotMatch(await page.textContent(".bars"), /of the surface/); // one bar
    await set(page, { shapeOpacity: 0.4 });
    const titles = await page.$$eval(".colour-title", (all) => all.filter((e) => e.offsetParent).map((e) => e.textContent));
    assert.deepEqual(titles, ["erosion thickness (mm)", "thickness of the surface (mm)"]);
    await set(page, { surface: "nothing" });
    assert.deepEqual(await state(page, "surface"), ["none"]);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("medial meshes: a slider from the finest to the coarsest, errors, the envelope", async () => {
    const { page, complaints } = await open(whole(), `layer=simple&vertices=7&${top}`);
    assert.deepEqual(await page.evaluate("(({ faces, curveEdges, vertices, edges }) => [faces, curveEdges, vertices, edges])(window.quench.sets())"), [4, 2, 7, 10]);
    assert.match(await page.textContent(".info"), /Medial mesh: 7 vertices.*4 triangles, 2 edges beside/);
    await page.fill('.slider[data-id="vertices"] .field', "5");
    await page.press('.slider[data-id="vertices"] .field', "Enter");
    await settled(page);
    assert.deepEqual(await state(page, "vertices"), [5]);
    assert.match(await page.textContent(".what"), /off its envelope by 0.05 mm on average, 99 % below 0.1 mm, 0.2 mm at most/);
    const chi = () => page.evaluate("(({ faces, vertices, edges }) => vertices - edges + faces)(window.quench.sets())");
    for (const vertices of [5, 4, 3, 2, 1]) {
      await set(page, { vertices });
      assert.equal(await chi(), 1);
    }
    await set(page, { vertices: 0 });
    assert.deepEqual(await state(page, "vertices"), [1]); // as few as there are
    await set(page, { vertices: 6 });
    await page.evaluate("document.activeElement.blur()");
    await page.keyboard.press("]");
    assert.deepEqual(await state(page, "vertices"), [7]);
    const picked = await page.evaluate("window.quench.pick(0)");
    assert.deepEqual([picked.position, picked.radius], [[2, 1, 1], 0.5]);
    await set(page, { ui: false, caption: false, shape: false, orthographic: true, vertices: 7, color: "none", sheets: false });
    const empty = await colourAt(page, 3.25, 1); // beside the triangles, in their slab
    await set(page, { balls: true });
    assert.notDeepEqual(await colourAt(page, 3.25, 1), empty);
    assert.match(await page.evaluate("location.hash"), /layer=simple/);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  for (const [name, change, expected] of [
    ["a table that is too short", (arrays) => ({ ...arrays, "sheets/area": ["f32", 1, [2]] }), /table of sheets/],
    ["a column that is missing", ({ "sheets/area": _, ...arrays }) => arrays, /sheets\/area is missing/],
    ["values of another surface", (arrays) => ({ ...arrays, "shape/point/thickness": ["f32", 1, [1, 2]] }), /2 values for 8 points/],
    ["steps of what is gone", (arrays) => ({ ...arrays, "simple/steps": ["u32", 2, [0, 1, 1, 2, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3]] }), /do not fit together/],
    ["meshes without steps", ({ "simple/steps": _, ...arrays }) => arrays, /simple\/steps is missing/],
  ])
    it(`damaged: ${name}`, async () => {
      const { page } = await open(whole(change));
      assert.match(await page.evaluate("window.quench.error"), expected);
      await page.close();
    });
});
