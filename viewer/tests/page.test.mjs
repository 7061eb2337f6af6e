// SPDX-License-Identifier: Apache-2.0
// The page in a browser. Skipped where there is no Chromium.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { describe } from "node:test";
import { browserOf, colourIn, coloursIn, pixelsOf, SCALE } from "./browser.mjs";
import { boxCore, boxPage, boxShape, boxSkeleton, layerArrays, otherLevels, pageOf, planePage, randomCells } from "./fixture.mjs";

describe("the page in a browser", () => {
  const { it, open, settled, template } = browserOf();
  const sets = (page, change = {}) => page.evaluate((c) => (window.quench.set(c), window.quench.sets()), change);

  it("loads without a complaint, shows its title and figures", async () => {
    const { page, complaints } = await open(boxPage(template));
    assert.equal(await page.title(), "box");
    assert.equal(await page.evaluate("window.quench.error"), null);
    assert.equal(await page.evaluate("window.quench.state.layer"), "skeleton");
    await settled(page);
    const text = await page.textContent("#app");
    for (const wanted of ["Skeleton", "1 component", "quench skeleton core.vtp --theta2 0.3abs --theta1 0.3abs --tips pruned -o skeleton.vtp"]) assert.ok(text.includes(wanted), wanted);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("sliders give the sets, by script and by hand", async () => {
    const { page, complaints } = await open(boxPage(template));
    const at = async (change) => { const s = await sets(page, change); return [s.faces, s.curveEdges, s.freeEnds, s.isolated]; };
    assert.deepEqual(await at({ theta2: 0, theta1: 0 }), [1, 8, 4, 0]);
    assert.deepEqual(await at({ theta1: 0.3 }), [1, 5, 1, 1]);
    assert.deepEqual(await at({ theta2: 1, theta1: 0 }), [0, 9, 5, 0]);
    assert.deepEqual(await at({ theta2: Infinity, theta1: Infinity }), [0, 3, 0, 2]);
    assert.deepEqual(await at({ theta2: 0, theta1: 0 }), [1, 8, 4, 0]);
    assert.deepEqual(await at({ layer: "core", threshold: 0 }), [12, 0, 0, 0]);
    assert.deepEqual(await at({ threshold: 0.6 }), [8, 0, 0, 0]);
    await at({ layer: "skeleton", theta2: 0, theta1: 0 });
    await settled(page);
    const field = page.locator('[data-id="theta1"] .field');
    await field.fill("0.3");
    await field.press("Enter");
    assert.equal((await sets(page)).curveEdges, 5);
    const range = page.locator('[data-id="theta2"] input[type=range]');
    await range.focus();
    await range.press("End");
    assert.equal(await page.evaluate("window.quench.state.theta2"), Infinity);
    assert.equal((await sets(page)).faces, 0);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("opens with the skeleton asked for; sliders show its family, and come back", async () => {
    const { page, complaints } = await open(boxPage(template, { meta: (m) => ({ ...m, floor: { theta2: 0.5, theta1: 0.4 }, note: "The sliders begin at theta2 = 0.5." }) }, undefined, true));
    const at = async (change) => { const s = await sets(page, change); return [s.faces, s.curveEdges, s.freeEnds, s.isolated]; };
    const thetas = () => page.evaluate("[window.quench.state.theta2, window.quench.state.theta1]");
    const asked = Math.fround(0.3), shown = [1, 5, 1, 1];
    assert.deepEqual(await at({}), shown); // the branch of two edges, the loop of three, the point
    assert.ok((await thetas()).every((x) => Math.abs(x - asked) < 1e-7)); // below the floor
    assert.match(await page.textContent(".note"), /^The sliders begin at/);
    assert.match(await page.textContent(".what"), /\(as asked\)/);
    assert.ok(!(await page.isVisible(".asked")));
    assert.deepEqual(await at({ theta2: 1, theta1: 0 }), [0, 6, 2, 1]); // of the family, from its floors on
    assert.deepEqual((await thetas()).map((x) => Number(x.toPrecision(6))), [1, 0.4]);
    assert.ok(await page.isVisible(".asked"));
    await page.click(".asked");
    assert.deepEqual(await at({}), shown);
    const range = page.locator('[data-id="theta2"] input[type=range]');
    await range.focus();
    await range.press("End");
    assert.equal((await sets(page)).faces, 0);
    await range.press("Home");
    await sets(page, { theta1: 0.3 });
    await range.press("ArrowRight");
    await range.press("Home"); // where the handle of what was asked for stands
    const [theta2, theta1] = await thetas();
    assert.equal(theta2 <= 0.5, true);
    assert.equal(theta1 >= asked, true);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("sheets of the family end inside their parts where the levels of corners say so", async () => {
    // The sheet's level is 0.6; at the corners 0 and 3 it is 0.6, at 1 and 2 it is 0.1: half of it is above 0.35.
    const corners = (levels) => (arrays) => ({ ...arrays, "family/corner_level": ["f32", 1, levels] });
    const covered = async (levels, theta2) => {
      const { page, complaints } = await open(boxPage(template, {}, corners(levels)), `ui=0&shape=0&color=none&curves=0&points=0&boundary=0&seams=0&caption=0&theta2=${theta2}&theta1=0&camera=2,1,8,2,1,1,0,1,0`);
      await settled(page);
      const { data, channels, width, height } = pixelsOf(await page.screenshot());
      let count = 0;
      for (let i = 0; i < width * height; ++i) count += Number(data[channels * i] < 215); // darker than the paper
      assert.deepEqual(complaints, []);
      await page.close();
      return count;
    };
    const whole = await covered([0.6, 0.6, 0.6, 0.6], 0.35), part = await covered([0.6, 0.1, 0.1, 0.6], 0.35), above = await covered([0.6, 0.1, 0.1, 0.6], 0.05);
    assert.ok(whole > 2000 * SCALE * SCALE, String(whole));
    assert.ok(Math.abs(part / whole - 0.5) < 0.03, `${part} of ${whole}`);
    assert.ok(Math.abs(above / whole - 1) < 0.02, `${above} of ${whole}`);
  });

  it("branches: table, sorting, CSV, picking by row and by click", async () => {
    const { page, complaints } = await open(boxPage(template, {}, undefined, true), "table=1&shape=0");
    await settled(page);
    const rows = () => page.$$eval(".branch-rows .branch-row", (all) => all.map((row) => [...row.children].map((cell) => cell.textContent)));
    assert.deepEqual((await rows()).map((row) => row[0]), ["0", "1"]); // the longer first
    assert.equal((await rows())[0][7], "sheet – end");
    await page.click(".branch-head .branch-cell:nth-child(2)");
    assert.deepEqual((await rows()).map((row) => row[0]), ["1", "0"]);
    await page.click(".branch-head .branch-cell:nth-child(6)"); // infinite first
    assert.deepEqual((await rows()).map((row) => row[5]), ["∞", "0.8"]);
    const csv = (await page.evaluate("window.quench.branches()")).trim().split("\n");
    assert.equal(csv[0], "branch,length,mean_radius,min_radius,max_radius,thickness,tortuosity,ends");
    assert.equal(csv.length, 3);
    assert.match(csv[1], /^1,.*,inf,inf,loop-loop$/);
    await page.click('.branch-rows [data-branch="0"]');
    assert.equal(await page.evaluate("window.quench.state.branch"), 0);
    await settled(page);
    assert.match(await page.textContent(".chosen-branch"), /Branch 0.*length.*1\.207 mm/s);
    await page.keyboard.press("Escape");
    assert.equal(await page.evaluate("window.quench.state.branch"), -1);
    // A click on the middle of the free branch, seen from above.
    await page.evaluate("window.quench.set({ ui: false, table: false })");
    await page.goto(page.url().split("#")[0] + "#ui=0&shape=0&camera=0.75,1,12,0.75,1,1,0,1,0");
    await page.reload();
    await page.waitForFunction("window.quench.ready");
    await page.mouse.click(500, 350 + 10);
    await settled(page);
    assert.equal(await page.evaluate("window.quench.state.branch"), 0);
    for (const color of ["sheet", "branch"]) {
      await sets(page, { color });
      await settled(page);
      assert.ok(coloursIn(await page.screenshot()).size > 20);
    }
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("the core is pruned by each measure of the page, from that of its burning on", async () => {
    const measures = [{ name: "lambda", floor: 0 }, { name: "detail", floor: 0.1 }], pruning = { measure: "detail", threshold: 0.375 };
    const arrays = { ...layerArrays("core", boxCore()), ...layerArrays("family", boxSkeleton()) };
    Object.assign(arrays, otherLevels(arrays, "detail", (v) => v / 8));
    arrays["core/point/detail"] = ["f32", 1, arrays["core/points"][2].filter((_, i) => i % 3 === 0).map((_, v) => (v === 0 ? Infinity : v / 8))];
    const { page, complaints } = await open(pageOf(template, { measures, pruning }, arrays), "layer=core");
    const faces = async (change) => (await sets(page, change)).faces;
    const start = () => page.evaluate("[window.quench.state.measure, window.quench.state.threshold]");
    const expected = (threshold) => arrays["core/face_level/detail"][2].filter((x) => x >= threshold).length;
    assert.deepEqual(await start(), ["detail", 0.375]);
    for (const threshold of [0.1, 0.375, 0.75, 1.1]) assert.equal(await faces({ threshold }), expected(threshold), String(threshold));
    await settled(page);
    assert.match(await page.textContent("#app"), /pruned at detail = 1\.1 mm; burn times belong to detail = 0\.375 mm \(1\.5 voxels\)/);
    assert.match(await page.textContent("#app"), /burned at\s*detail = 0\.375 mm/);
    assert.match(await page.textContent(".burner"), /pruned at detail = 0\.375 mm/);
    assert.match(await page.textContent(".command"), /quench core box\.off --detail 1\.1abs -o core\.vtp/);
    const slider = page.locator('[data-id="threshold"]');
    assert.match(await slider.textContent(), /^detailmm.*voxels$/);
    assert.match(await slider.getAttribute("title"), /sticks out less/);
    await slider.locator(".field").fill("0.75");
    await slider.locator(".field").press("Enter");
    assert.equal(await faces({}), expected(0.75));
    assert.equal(await faces({ measure: "lambda" }), 12); // a threshold belongs to its measure
    assert.equal(await faces({ threshold: 0.625 }), 8);
    await settled(page);
    assert.match(await page.textContent("#app"), /pruned at λ = 0\.625 mm; burn times belong to detail = 0\.375 mm/);
    assert.match(await page.textContent(".command"), /--lambda 0\.625abs/);
    assert.match(await slider.getAttribute("title"), /thinner than this radius/);
    await page.waitForFunction("location.hash.includes('measure=lambda') && location.hash.includes('threshold=0.625')");
    await faces({ measure: "detail", color: "detail" });
    assert.deepEqual(await start(), ["detail", 0.375]);
    await settled(page);
    assert.match(await page.textContent(".colour-bar"), /^detail \(mm\).*infinite: always kept/);
    await faces({ measure: "unknown", threshold: 1 });
    assert.deepEqual(await start(), ["detail", 0.375]);
    assert.equal(await faces({ layer: "skeleton", theta2: 0 }), 1);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("a measure that no command prunes by, in degrees", async () => {
    const measures = [{ name: "lambda", floor: 0 }, { name: "object_angle", floor: 0 }];
    const arrays = layerArrays("core", boxCore());
    Object.assign(arrays, otherLevels(arrays, "object_angle", (v) => 15 * v));
    const { page, complaints } = await open(pageOf(template, { measures }, arrays), "measure=object_angle&threshold=60");
    await settled(page);
    assert.match(await page.textContent("#app"), /pruned at object angle = 60°/);
    assert.ok(!(await page.isVisible(".command")));
    assert.equal(await page.textContent('[data-id="threshold"]'), "object angle°");
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("picking by number: position, measures, touching points", async () => {
    const { page, complaints } = await open(boxPage(template), "layer=core&threshold=0");
    const end = await page.evaluate("window.quench.pick(0)"); // (1, 1, 1), radius 1: one point of each of five faces
    assert.deepEqual(end.position, [1, 1, 1]);
    assert.equal(end.radius, 1);
    assert.ok(Math.abs(end.measures.burn_time - 1.7) < 1e-6);
    assert.deepEqual(end.touching.map((p) => p.join(" ")).sort(), ["0 1 1", "1 0 1", "1 1 0", "1 1 2", "1 2 1"]);
    const middle = await page.evaluate("window.quench.pick(1)");
    assert.equal(middle.touching.length, 5);
    await settled(page);
    assert.match(await page.textContent(".picked"), /Point 1.*radius.*1 mm.*boundary at 5 points/s);
    await page.keyboard.press("Escape");
    await settled(page);
    assert.equal(await page.textContent(".picked"), "");
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("picking with the mouse finds the vertex under it", async () => {
    for (const projection of ["", "&orthographic=1"]) {
      // From straight above; the inner end of the ridge is in the middle of the free part of the window.
      const { page } = await open(boxPage(template), `layer=core&threshold=0&ui=0&camera=1,1,12,1,1,1,0,1,0${projection}`);
      await page.mouse.click(500 + 3, 350 + 2);
      await page.evaluate("window.quench.set({ ui: true })");
      await settled(page);
      assert.match(await page.textContent(".picked h2"), /^Point 0$/, projection);
      await page.close();
    }
  });

  it("the picture is not blank, differs between colourings, and is the same twice", async () => {
    const { page, complaints } = await open(boxPage(template), "layer=core&threshold=0&ui=0&color=radius");
    const shot = async (change) => {
      await sets(page, change);
      await settled(page);
      return page.screenshot();
    };
    const radius = await shot({}), again = await shot({}), burn = await shot({ color: "burn_time", map: "cividis" }), none = await shot({ color: "none" });
    assert.ok(coloursIn(radius).size > 40);
    assert.deepEqual(radius, again);
    assert.notDeepEqual(radius, burn);
    assert.notDeepEqual(burn, none);
    const clipped = await shot({ clip: true, clipAxis: "z" }), balls = await shot({ clip: false, balls: true });
    assert.notDeepEqual(clipped, none);
    assert.notDeepEqual(balls, none);
    const dark = await shot({ dark: true });
    const { data } = pixelsOf(dark);
    assert.ok(data[0] < 60);
    assert.ok(pixelsOf(radius).data[0] > 200);
    await page.evaluate("window.quench.set({ ui: true })");
    await settled(page);
    const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("p")]);
    assert.equal(download.suggestedFilename(), "box.png");
    assert.ok(coloursIn(readFileSync(await download.path())).size > 20);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("the balls of all of the axis fill the shape, those of less fill less", async () => {
    const { page } = await open(boxPage(template), "layer=core&threshold=0&balls=1");
    await page.waitForFunction("/fill/.test(document.querySelector('.share').textContent)");
    // Two balls of radius 1 in a box of 16, counted with 2000 samples.
    const share = Number(/([\d.]+) %/.exec(await page.textContent(".share"))[1]);
    assert.ok(Math.abs(share - (100 * (2 * 4 * Math.PI)) / 3 / 16) < 3, `${share}`);
    await page.close();
  });

  it("the plane is seen from the front, y as the page says, and moves instead of turning", async () => {
    for (const y of ["down", "up"]) {
      const { page, complaints } = await open(planePage(template, y), "ui=0&caption=0");
      await settled(page);
      const picture = pixelsOf(await page.screenshot());
      // What lacks a quarter: at the right, at large y. 960 pixels for four units.
      const filled = (x, above) => colourIn(picture, x, 350 + (above ? -100 : 100))[0] < 225;
      assert.deepEqual([filled(200, true), filled(200, false), filled(800, true), filled(800, false)], [true, true, y === "down", y === "up"]);
      const camera = async () => {
        await page.waitForTimeout(400); // the address follows
        const text = /camera=([^&]*)/.exec(decodeURIComponent(page.url()))?.[1];
        return text ? text.split(",").map(Number) : null;
      };
      await page.mouse.move(500, 350);
      await page.mouse.down();
      await page.mouse.move(600, 300, { steps: 5 });
      await page.mouse.up();
      const [px, py, pz, tx, ty, tz, ux, uy, uz] = await camera(), sign = y === "down" ? -1 : 1;
      assert.ok(Math.abs(px - tx) < 1e-6 && Math.abs(py - ty) < 1e-6 && sign * (pz - tz) > 0);
      assert.deepEqual([ux, uy, uz].map(Math.round).map((u) => u + 0), [0, sign, 0]);
      assert.ok(tx < 2 - 0.3 && sign * (ty - 1) < -0.1, `${tx} ${ty}`); // what was dragged came along
      for (const key of ["x", "o", "ArrowLeft", "Alt+KeyX"]) await page.keyboard.press(key);
      assert.deepEqual(await page.evaluate("[window.quench.state.clip, window.quench.state.orthographic]"), [false, true]);
      await page.mouse.dblclick(300, 300);
      await page.waitForFunction("Math.abs(Number(/camera=([^&]*)/.exec(decodeURIComponent(location.hash))?.[1].split(',')[3]) - 2) < 0.05");
      const [, , , x, y_] = await camera();
      assert.ok(Math.abs(x - 2) < 0.05 && Math.abs(y_ - 1) < 0.05, `${x} ${y_}`);
      assert.deepEqual(complaints, []);
      await page.close();
    }
  });

  it("in the plane there are one theta, disks and pixels", async () => {
    const { page, complaints } = await open(planePage(template, "down"), "theta1=0.3");
    const at = async (change) => { const s = await sets(page, change); return [s.faces, s.curveEdges, s.freeEnds]; };
    assert.deepEqual(await at({}), [0, 3, 2]);
    assert.deepEqual(await at({ theta1: 0 }), [0, 4, 3]);
    await page.waitForSelector('[data-id="theta1"]');
    assert.equal(await page.$('[data-id="theta2"]'), null);
    await page.keyboard.press("]");
    assert.ok((await page.evaluate("window.quench.state.theta1")) > 0);
    await settled(page);
    const skeleton = await page.textContent("#app");
    assert.match(skeleton, /Skeleton: curves of erosion thickness ≥/);
    assert.match(skeleton, /quench skeleton core\.vtp --theta1 \S+ --tips pruned/);
    for (const word of [/voxel/, /ball/, /θ₂(?! of)/, /sheets/, /surface/, /clip/, /orthographic/]) assert.doesNotMatch(skeleton.replace(/\[ \].*/, ""), word);
    assert.deepEqual(await at({ layer: "core", threshold: 0.75 }), [0, 2, 2]);
    await page.waitForSelector('[data-id="threshold"]');
    const end = await page.evaluate("window.quench.pick(0)"); // its disk touches three sides
    assert.deepEqual(end.touching.map((p) => p.join(" ")).sort(), ["0 1 0", "1 0 0", "1 2 0", "2 1 0"]);
    await settled(page);
    assert.match(await page.textContent(".picked"), /position\s*1, 1(?!,).*disk touches.*outline at 4 points/s);
    await sets(page, { color: "mgf" });
    await settled(page);
    assert.match(await page.textContent(".colour-bar"), /MGF \(px\).*infinite: between two outlines/);
    const before_ = await page.screenshot();
    await sets(page, { balls: true });
    await page.waitForFunction("/disks.*fill/.test(document.querySelector('.share').textContent)");
    let inside = 0;
    for (let j = 0; j < 20; ++j) for (let i = 0; i < 40; ++i) inside += Number((i < 20 || j < 10) && [[1, 1, 1], [3.5, 0.5, 0.5], [2, 0.5, 0.5]].some(([x, y, r]) => Math.hypot(0.05 + 0.1 * i - x, 0.05 + 0.1 * j - y) < r));
    assert.match(await page.textContent(".share"), new RegExp(`${((100 * inside) / 600).toFixed(1).replace(".", "\\.")} %`));
    assert.notDeepEqual(await page.screenshot(), before_);
    await page.keyboard.press("?");
    assert.match(await page.textContent(".help"), /double click\s*whole view again/);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("burning hides what burned", async () => {
    const { page, complaints } = await open(boxPage(template), "layer=core&threshold=0&ui=0&shape=0");
    const shot = async (change) => (await sets(page, change), await settled(page), page.screenshot());
    const before_ = await shot({}), during = await shot({ burn: true, time: 0.9, burnHides: true }), gone = await shot({ time: 9 });
    assert.notDeepEqual(before_, during);
    assert.ok(coloursIn(gone).size < coloursIn(during).size);
    await page.evaluate("window.quench.set({ burn: false, ui: true })");
    await page.keyboard.press(" ");
    await page.waitForFunction("window.quench.state.burn && window.quench.state.time > 0");
    await page.keyboard.press(" ");
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("the address is read and written", async () => {
    const hash = "layer=core&threshold=0.6&color=radius&dark=1&camera=9,8,7,1,1,1,0,0,1";
    const { page } = await open(boxPage(template), hash);
    const state = await page.evaluate("window.quench.state");
    assert.deepEqual([state.layer, state.color, state.dark, Math.fround(0.6) - state.threshold < 1e-7], ["core", "radius", true, true]);
    assert.equal((await sets(page)).faces, 8);
    await sets(page, { threshold: 0.8, theta2: Infinity });
    await page.waitForFunction("location.hash.includes('threshold=0.8') || location.hash.includes('threshold=0.79999')");
    const written = await page.evaluate("location.hash");
    assert.match(written, /theta2=inf/);
    assert.match(written, /camera=9,8,7,1,1,1,/);
    const { page: second } = await open(boxPage(template), written.slice(1));
    assert.deepEqual(await second.evaluate("window.quench.state"), await page.evaluate("window.quench.state"));
    await page.close();
    await second.close();
  });

  it("keys, help and the state a page is written with", async () => {
    const { page, complaints } = await open(boxPage(template, { meta: (m) => ({ ...m, state: "layer=core&color=radius", notes: ["A note <b>here</b>."] }) }));
    assert.equal(await page.evaluate("window.quench.state.color"), "radius");
    assert.equal(await page.textContent(".note"), "A note <b>here</b>.");
    await page.keyboard.press("?");
    assert.ok(await page.isVisible(".help"));
    await page.keyboard.press("Escape");
    assert.ok(!(await page.isVisible(".help")));
    for (const [key, field] of [["s", "sheets"], ["o", "orthographic"], ["d", "dark"], ["x", "clip"], ["h", "ui"]]) {
      const was = await page.evaluate((f) => window.quench.state[f], field);
      await page.keyboard.press(key);
      assert.equal(await page.evaluate((f) => window.quench.state[f], field), !was, key);
    }
    await page.keyboard.press("1");
    assert.equal(await page.evaluate("window.quench.state.layer"), "skeleton");
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("random complexes, one layer at a time, without a shape", async () => {
    for (const [seed, name] of [[11, "core"], [12, "skeleton"], [13, "still"]]) {
      const cells = randomCells(seed, name === "skeleton");
      const { page, complaints } = await open(pageOf(template, { side: 1, low: [0, 0, 0], high: [1, 1, 1], voxel: undefined }, layerArrays(name === "skeleton" ? "family" : name, cells)));
      assert.equal(await page.evaluate("window.quench.state.layer"), name);
      assert.ok((await sets(page)).vertices > 0);
      assert.deepEqual(complaints, []);
      await page.close();
    }
  });

  const broken = {
    "cut off": { damage: { data: (z) => z.toString("base64").slice(0, 401) }, says: /cut off|damaged/ },
    "cut off at a byte": { damage: { data: (z) => z.toString("base64").slice(0, 400) }, says: /cut off|incomplete/ },
    "no base64": { damage: { data: () => "%%%% no" + "!".repeat(1) }, says: /base64/ },
    "no gzip": { damage: { data: () => Buffer.from("not gzip at all, but long enough").toString("base64") }, says: /unpacked/ },
    "no data": { damage: { data: () => "" }, says: /unpacked|incomplete/ },
    "too short": { damage: { meta: (m) => ({ ...m, arrays: m.arrays.map((a) => ({ ...a, count: a.count + 1000 })) }) }, says: /incomplete/ },
    "another format": { damage: { meta: (m) => ({ ...m, format: 7 }) }, says: /format 7/ },
    "an unknown type": { damage: { meta: (m) => ({ ...m, arrays: m.arrays.map((a) => ({ ...a, type: "f16" })) }) }, says: /does not know/ },
    "no size": { damage: { meta: (m) => ({ ...m, side: null }) }, says: /how large/ },
    "missing edges": { change: (a) => { delete a["family/polygon_edges"]; return a; }, says: /polygon_edges is missing/ },
    "missing levels": { change: (a) => { delete a["core/face_level"]; return a; }, says: /face_level is missing/ },
    "missing levels of a measure": { damage: { meta: (m) => ({ ...m, measures: [{ name: "lambda", floor: 0 }, { name: "size", floor: 0 }] }) }, says: /face_level\/size is missing/ },
    "levels of no measure": { damage: { meta: (m) => ({ ...m, measures: undefined }) }, says: /by which measure/ },
    "levels of another length": { change: (a) => { a["core/edge_level"][2].pop(); return a; }, says: /values for/ },
    "corners beyond the end": { change: (a) => { a["core/polygon_corners"][2][0] = 999; return a; }, says: /beyond its end/ },
    "unsorted faces": { change: (a) => { a["core/face_level"][2].reverse(); return a; }, says: /not sorted/ },
    "points that are not numbers": { change: (a) => { a["core/points"][2].fill(NaN); return a; }, says: /not numbers/ },
    "empty layers": { change: (a) => { for (const n of ["core", "family"]) a[`${n}/points`][2] = []; return a; }, says: /no medial axis/ },
  };
  for (const [what, { damage, change, says }] of Object.entries(broken))
    it(`damaged: ${what}`, async () => {
      const { page, complaints } = await open(boxPage(template, damage, change));
      const error = await page.evaluate("window.quench.error");
      assert.match(error, says);
      assert.equal(await page.evaluate("window.quench.ready"), false);
      assert.ok((await page.innerText(".message")).includes(error));
      assert.deepEqual(complaints, []);
      await page.close();
    });

  it("measures that are nowhere a number are grey, and the page says so", async () => {
    const { page, complaints } = await open(boxPage(template, {}, (a) => {
      for (const [name, array] of Object.entries(a)) if (name.includes("/point/")) array[2] = array[2].map(() => NaN);
      return a;
    }));
    assert.equal(await page.evaluate("window.quench.error"), null);
    await settled(page);
    assert.match(await page.textContent(".colour-bar"), /no value anywhere/);
    assert.deepEqual((await page.evaluate("window.quench.pick(0)")).touching, []);
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("a shape far from zero is drawn and picked where it is", async () => {
    const far = [4e6, -5e6, 250];
    const shape = boxShape();
    const m = shape.meta.sites_to_world.slice();
    far.forEach((x, k) => { m[4 * k + 3] += x; });
    const { page } = await open(pageOf(template, { ...shape.meta, sites_to_world: m, origin: far, low: far, high: [far[0] + 4, far[1] + 2, far[2] + 2] }, { ...layerArrays("core", boxCore()), ...layerArrays("family", boxSkeleton()), ...shape.arrays }));
    const picked = await page.evaluate("(window.quench.set({ layer: 'core', threshold: 0 }), window.quench.pick(0))");
    assert.deepEqual(picked.position, [4000001, -4999999, 251]);
    assert.equal(picked.touching.length, 5);
    await settled(page);
    assert.ok(coloursIn(await page.screenshot()).size > 40);
    await page.close();
  });

  it("runs in the frame of a notebook, which has no address", async () => {
    const inside = boxPage(template).replaceAll("&", "&amp;").replaceAll('"', "&quot;");
    const { page, complaints } = await open(`<script>window.quench = { ready: true }</script><iframe width="900" height="600" sandbox="allow-scripts allow-downloads" srcdoc="${inside}"></iframe>`);
    const frame = page.frames()[1];
    await frame.waitForFunction("window.quench && (window.quench.ready || window.quench.error)", null, { timeout: 60000 });
    assert.equal(await frame.evaluate("window.quench.error"), null);
    assert.deepEqual(await frame.evaluate("(window.quench.set({ theta2: 0, theta1: 0 }), window.quench.sets().curveEdges)"), 8);
    await frame.evaluate(() => new Promise((done) => setTimeout(done, 300))); // after the timer that remembers the state
    assert.deepEqual(complaints, []);
    await page.close();
  });

  it("the empty template says what it is", async () => {
    const { page, complaints } = await open(template);
    assert.match(await page.innerText(".message"), /empty page/);
    assert.deepEqual(complaints, []);
    await page.close();
  });
});
