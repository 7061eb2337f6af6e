// SPDX-License-Identifier: Apache-2.0
// Pages of trees in a browser.
import assert from "node:assert/strict";
import { describe } from "node:test";
import { browserOf, colourIn, pixelsOf } from "./browser.mjs";
import { boxCore, boxPage, boxShape, layerArrays, treePage } from "./fixture.mjs";

describe("pages of trees", () => {
  const { it, open, settled, template } = browserOf();
  const set = async (page, change) => {
    await page.evaluate((c) => window.quench.set(c), change);
    await settled(page);
  };
  const state = (page, ...keys) => page.evaluate((k) => k.map((key) => window.quench.state[key]), keys);
  const rows = (page) => page.$$eval(".branch-rows .branch-row", (all) => all.map((row) => [...row.children].map((cell) => cell.textContent)));
  /// The colours where places in the plane y = 0 are seen from the front: 700 pixels for 4.4 units around (0.5, -2), ten below the middle.
  const front = "camera=0.5,-8.2104,-2,0.5,0,-2,0,0,1&ui=0&caption=0";
  const pixel = (x, z) => [Math.round(500 + ((x - 0.5) * 700) / 4.4), Math.round(360 - ((z + 2) * 700) / 4.4)];
  const coloursAt = async (page, ...places) => {
    const picture = pixelsOf(await page.screenshot());
    return places.map(([x, z]) => colourIn(picture, ...pixel(x, z)));
  };
  const hue = ([r, g, b]) => (r > 200 && g > 200 && b > 200 ? "paper" : b > r + 25 ? "blue" : r > b + 50 && r > g + 25 ? "orange" : g > r + 20 && g > b + 20 ? "green" : "other");

  it("is shown first, upright, as tubes in the colours of its levels, with its figures", async () => {
    const { page, complaints } = await open(treePage(template), front);
    await settled(page);
    assert.deepEqual(await state(page, "layer", "color", "tubes"), ["tree", "level", true]);
    const hues = async (...places) => (await coloursAt(page, ...places)).map(hue);
    assert.deepEqual(await hues([0, -3], [0.15, -3], [0.28, -3], [1.5, -1], [-0.8, -2], [1, -1.6], [1.12, -1.6]), ["blue", "blue", "paper", "orange", "orange", "green", "paper"]);
    await set(page, { tubes: false }); // lines are thinner than the stem
    assert.deepEqual(await hues([0, -3], [0.15, -3]), ["blue", "paper"]);
    await set(page, { tubes: true, color: "bridged", bridges: false, cuts: false });
    assert.deepEqual(await hues([0, -3], [-0.8, -2], [1.5, -1]), ["blue", "orange", "blue"]);
    await set(page, { color: "level", ui: true });
    const text = await page.textContent("#app");
    for (const wanted of [/Tree/, /4 in 7 branches/, /total length\s*8 mm/, /depth\s*4 mm/, /level 1\s*2\s*3 mm/, /1 bridge/, /1 cut/, /1 part left out/, /quench tree root\.ply -o root/]) assert.match(text, wanted);
    assert.equal(await page.textContent(".colour-title"), "level");
    for (const color of ["strahler", "order", "radius", "angle_to_down", "axis", "branch", "axes/length", "branches/length", "axes/angle"]) {
      await set(page, { color });
      assert.equal((await state(page, "color"))[0], color);
    }
    assert.match(await page.textContent(".colour-bar"), /angle of the axis \(°\).*no value here/);
    await set(page, { color: "axes/nothing" });
    assert.equal((await state(page, "color"))[0], "level");
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("starts from the side it says, and comes back to it", async () => {
    const { page } = await open(treePage(template));
    // The address follows.
    const camera = async (fits) => {
      await page.waitForFunction(`(${fits})(...(/camera=([^&]*)/.exec(decodeURIComponent(location.hash))?.[1] ?? "").split(",").map(Number))`);
      return /camera=([^&]*)/.exec(decodeURIComponent(page.url()))[1].split(",").map(Number);
    };
    await page.keyboard.press("ArrowLeft");
    await camera((px, py, pz, tx) => Math.abs(px - tx) > 0.1);
    await page.keyboard.press("f");
    const [, , , tx, , tz, ux, uy, uz] = await camera((px, py, pz, tx, ty, tz) => Math.abs(px - tx) < 1e-4 && Math.abs(pz - tz) < 1e-4 && py < ty - 1);
    assert.deepEqual([ux, uy, uz].map(Math.round).map((x) => x + 0), [0, 0, 1]);
    assert.ok(Math.abs(tx - 0.5) < 0.3 && Math.abs(tz + 2) < 0.3);
    await page.close();
  });

  it("tables: axes and branches sorted, picked by row and by click, with the way to the root node", async () => {
    const { page, complaints } = await open(treePage(template), "table=1");
    await settled(page);
    assert.deepEqual((await rows(page)).map((r) => r[0]), ["0", "1", "2", "3"]); // by length
    assert.deepEqual((await rows(page))[1], ["1", "1", "axis of level 1", "2", "90"]);
    await page.click(".branch-head .branch-cell:nth-child(5)"); // what has no angle comes last, both ways
    assert.deepEqual((await rows(page)).map((r) => r[4]), ["90", "90", "90", "–"]);
    await page.click(".branch-head .branch-cell:nth-child(5)");
    assert.deepEqual((await rows(page)).map((r) => r[4]), ["90", "90", "90", "–"]);
    const csv = (await page.evaluate("window.quench.branches()")).trim().split("\n");
    assert.deepEqual([csv[0], csv[4]], ["axis,level,class,length,angle", "0,0,stem,4,"]);
    await page.click('.branch-rows [data-branch="3"]');
    assert.deepEqual(await state(page, "axis", "rows"), [3, "axes"]);
    await settled(page);
    assert.match(await page.textContent(".tree-info"), /Axis 3.*class\s*axis of level 2.*length\s*1 mm.*angle\s*90°/s);
    await page.waitForFunction("/axis=3/.test(location.hash) && /camera/.test(location.hash)"); // it flew there
    await page.click(".branch-tabs button:nth-child(2)");
    await settled(page);
    assert.equal((await rows(page)).length, 7);
    await page.locator(".branch-body").focus();
    await page.keyboard.press("ArrowDown");
    const [branch, axis] = await state(page, "branch", "axis");
    assert.deepEqual([branch, axis], [2, 0]); // the longest first
    await page.keyboard.press("Escape");
    assert.deepEqual(await state(page, "branch", "axis"), [-1, -1]);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("what is picked and the way from there stand out", async () => {
    const { page, complaints } = await open(treePage(template), `${front}&bridges=0&cuts=0`);
    await page.mouse.click(...pixel(1, -1.6));
    await settled(page);
    assert.deepEqual(await state(page, "axis", "branch"), [3, 6]);
    const dark = ([r, g, b]) => r + g + b < 200;
    const [parent, stem, below, beyond, [r, g, b]] = await coloursAt(page, [0.5, -1], [0, -0.5], [0, -3], [1.5, -1], [1, -1.6]);
    assert.ok(dark(parent) && dark(stem)); // along its parents
    assert.ok(!dark(below) && !dark(beyond));
    assert.ok(r > 180 && g > 110 && b < 90, `${[r, g, b]}`);
    await page.mouse.click(...pixel(3, -3)); // nothing there
    assert.deepEqual(await state(page, "axis", "branch"), [-1, -1]);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("a card follows the pointer", async () => {
    const { page } = await open(treePage(template), `table=1&${front.replace("&ui=0", "")}`);
    await settled(page);
    const box = await page.evaluate(() => window.quench.state.table);
    assert.equal(box, true);
    // Where the stem is on the screen now: the middle of the free part.
    for (let x = 300; x < 690; x += 6) {
      await page.mouse.move(x, 200);
      await settled(page);
      if (await page.isVisible(".near-card")) break;
    }
    assert.match(await page.textContent(".near-card"), /^axis \d.*length/s);
    assert.equal((await page.$$(".branch-row.near")).length, 1);
    await page.mouse.move(310, 690);
    await settled(page);
    await page.waitForFunction("document.querySelector('.near-card').hidden");
    await page.close();
  });

  it("steps through repairs, which have marks, a list and a place", async () => {
    const { page, complaints } = await open(treePage(template), `${front}`);
    await settled(page);
    const cyan = ([r, g, b]) => b > 180 && g > 150 && r < 80, pink = ([r, g, b]) => r > 190 && g < 90 && b > 60;
    const [bridge, cut, left] = await coloursAt(page, [-0.5, -2], [1.9, -1], [3, -3.25]);
    assert.ok(cyan(bridge) && pink(cut), `${bridge} ${cut}`);
    assert.equal(hue(left), "paper"); // what was left out is not marked at first
    await page.keyboard.press("m");
    await settled(page);
    assert.equal(hue((await coloursAt(page, [-0.5, -2]))[0]), "orange");
    await page.keyboard.press("m");
    await page.keyboard.press("h");
    const steps = [];
    for (const key of [".", ".", ".", ","]) {
      await page.keyboard.press(key);
      steps.push((await state(page, "edit"))[0]);
    }
    assert.deepEqual(steps, [0, 1, 0, 1]);
    await settled(page);
    assert.match(await page.textContent(".chosen-edit"), /Repair 1.*kind\s*cut touching.*cost\s*7.*place\s*1\.9, 0, −1/s);
    assert.match(await page.textContent(".edit-at"), /2 of 2/);
    await page.click(".edit-key[data-group=leftOut]");
    await page.keyboard.press(".");
    assert.deepEqual(await state(page, "edit", "leftOut"), [2, true]);
    await set(page, { table: true });
    assert.equal((await rows(page)).length, 3);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("thousands of axes: rows in sight only, the one that is picked is scrolled to", async () => {
    const { page, complaints } = await open(treePage(template, { repeat: 3000 }), "table=1&axis=2500");
    await settled(page);
    assert.ok((await rows(page)).length < 60);
    assert.deepEqual((await page.$$eval(".branch-row.chosen", (all) => all.map((row) => row.dataset.branch))), ["2500"]);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("beside other layers, and with the surface around", async () => {
    const shape = boxShape();
    const { page, complaints } = await open(treePage(template, { meta: { ...shape.meta, measures: [{ name: "lambda", floor: 0 }] }, change: (arrays) => ({ ...arrays, ...layerArrays("core", boxCore()), ...shape.arrays }) }), "axis=1");
    await settled(page);
    assert.deepEqual(await state(page, "layer", "shape"), ["tree", false]);
    await page.keyboard.press("g");
    await page.keyboard.press("2");
    await settled(page);
    assert.deepEqual(await state(page, "layer", "shape", "color"), ["core", true, "erosion_thickness"]);
    assert.ok(!(await page.isVisible(".tree-info")));
    await page.keyboard.press("0");
    assert.equal((await state(page, "layer"))[0], "tree");
    await page.close();
    assert.deepEqual(complaints, []);
    const { page: other } = await open(boxPage(template), "axis=3&rows=edits&tubes=0"); // of no tree: nothing of it
    assert.deepEqual(await state(other, "axis"), [-1]);
    await other.close();
  });

  const broken = {
    "no description": { meta: { tree: undefined }, says: /does not describe its tree/ },
    "parents after children": { change: (a) => { a["tree/branch_parent"][2][0] = 3; return a; }, says: /branch_parent.*damaged/ },
    "axes that are not there": { change: (a) => { a["tree/branch_axis"][2][0] = 99; return a; }, says: /branch_axis.*damaged/ },
    "a column of another length": { change: (a) => { a["tree/axes/length"][2].pop(); return a; }, says: /axes\/length.*damaged/ },
    "a missing column": { change: (a) => { delete a["tree/edits/cost"]; return a; }, says: /edits\/cost is missing/ },
    "branches without points": { change: (a) => { a["tree/branch_offsets"][2][1] = 1; return a; }, says: /branch_offsets.*damaged/ },
  };
  for (const [what, { says, ...options }] of Object.entries(broken))
    it(`damaged: ${what}`, async () => {
      const { page, complaints } = await open(treePage(template, options));
      assert.match(await page.evaluate("window.quench.error"), says);
      assert.deepEqual(complaints, []);
      await page.close();
    });
});
