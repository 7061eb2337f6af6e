// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The style and the script of the contact sheet of a batch.
namespace quench::program {

constexpr const char* kContactSheetStyle = R"css(
:root {
  color-scheme: light dark;
  --text: #171b21; --quiet: #5b6470; --line: rgb(20 30 45 / 14%); --card: #fff; --field: rgb(20 30 45 / 6%);
  --paper: #f4f6f8; --accent: #1a6f7b; --bad: #b3261e; --bad-ground: #fbeceb;
  font: 14px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", "Noto Sans", "Liberation Sans", sans-serif;
  font-variant-numeric: tabular-nums;
}
@media (prefers-color-scheme: dark) {
  :root {
    --text: #eef1f5; --quiet: #9aa5b3; --line: rgb(255 255 255 / 14%); --card: #1b2027; --field: rgb(255 255 255 / 8%);
    --paper: #14171c; --accent: #5cc0cc; --bad: #ff9d94; --bad-ground: #33211f;
  }
}
* { box-sizing: border-box; }
[hidden] { display: none !important; }
body { margin: 0; padding: 24px; background: var(--paper); color: var(--text); }
h1, h2, p, dl, dd { margin: 0; }
h1 { font-size: 24px; line-height: 1.2; font-weight: 620; letter-spacing: -0.012em; overflow-wrap: anywhere; }
header p { color: var(--quiet); margin-top: 4px; }
header .failed, header .missing { color: var(--bad); font-weight: 600; }
code { font: 12.5px/1.5 ui-monospace, "SF Mono", Menlo, Consolas, "DejaVu Sans Mono", "Liberation Mono", monospace; overflow-wrap: anywhere; }
a { color: inherit; text-decoration-color: var(--line); text-underline-offset: 3px; }
a:hover { color: var(--accent); }
:is(a, button, input, select):focus-visible { outline: 2px solid var(--accent); outline-offset: 1px; }

form { position: sticky; top: 0; z-index: 2; display: flex; flex-wrap: wrap; gap: 8px 16px; align-items: center; padding: 12px 0; margin: 8px 0; background: var(--paper); border-bottom: 1px solid var(--line); }
form :is(input[type="search"], select, button) { font: inherit; color: var(--text); background: var(--field); border: 0; border-radius: 6px; padding: 4px 10px; }
form option { background: var(--card); }
form button { cursor: pointer; }
#by { max-width: 260px; }
#turn { margin-left: -10px; }
.views { margin-left: auto; display: flex; gap: 2px; }
.views [aria-pressed="true"] { background: var(--accent); color: var(--paper); }

#cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(250px, 1fr)); gap: 16px; }
article { display: flex; flex-direction: column; background: var(--card); border: 1px solid var(--line); border-radius: 10px; overflow: hidden; }
article > :not(.picture) { margin-left: 14px; margin-right: 14px; }
.picture { aspect-ratio: 16 / 10; background: #fff; }
.picture > * { display: block; width: 100%; height: 100%; }
.picture img { display: block; width: 100%; height: 100%; object-fit: contain; }
.picture:has(.none) { background: var(--field); }
.picture .none { display: grid; place-items: center; color: var(--quiet); }
.failed .picture:has(.none) { background: var(--bad-ground); }
.failed .none { color: var(--bad); font-weight: 600; }
article h2 { font-size: 15px; font-weight: 620; padding-top: 10px; overflow-wrap: anywhere; }
article h2 a { text-decoration: none; }
.sentence { color: var(--bad); padding-top: 4px; overflow-wrap: anywhere; }
.missing .sentence { display: none; }
dl { display: grid; grid-template-columns: 1fr auto; gap: 1px 12px; padding-top: 6px; font-size: 13px; }
dt { color: var(--quiet); }
dd { text-align: right; }
i { font-style: normal; color: var(--quiet); }
article .links { margin-top: auto; padding: 8px 0 12px; font-size: 12px; color: var(--quiet); }
.links a { margin-right: 8px; }
.chosen { font-size: 13px; font-weight: 600; margin-top: 4px; padding-bottom: 4px; background: linear-gradient(var(--accent), var(--accent)) left bottom / calc(100% * var(--share, 0)) 3px no-repeat; overflow-wrap: anywhere; }

#table { overflow: auto; max-height: calc(100vh - 70px); border: 1px solid var(--line); border-radius: 10px; background: var(--card); }
table { border-collapse: separate; border-spacing: 0; font-size: 13px; }
th { position: sticky; top: 0; z-index: 1; background: var(--card); text-align: left; vertical-align: bottom; border-bottom: 1px solid var(--line); padding: 0; }
th button { font: inherit; font-weight: 600; color: inherit; background: none; border: 0; padding: 8px 12px; text-align: inherit; cursor: pointer; min-width: 100%; }
th[aria-sort="ascending"] button::after { content: " \2191"; }
th[aria-sort="descending"] button::after { content: " \2193"; }
td { padding: 5px 12px; border-bottom: 1px solid var(--line); max-width: 320px; white-space: nowrap; overflow: hidden; text-overflow: ellipsis; vertical-align: top; }
tr :is(td:first-child, td:nth-child(4)) { white-space: normal; overflow-wrap: anywhere; }
td:first-child { min-width: 120px; }
tr.failed td:nth-child(4) { min-width: 260px; }
td.n { text-align: right; }
td:first-child, th:first-child { position: sticky; left: 0; background: var(--card); }
th:first-child { z-index: 2; }
tr:last-child td { border-bottom: 0; }
tr.failed :is(td:nth-child(3), td:nth-child(4)) { color: var(--bad); }
)css";

constexpr const char* kContactSheetScript = R"js(
"use strict";
const find = (selector) => [...document.querySelectorAll(selector)];
const by = document.getElementById("by"), turn = document.getElementById("turn"), bad = document.getElementById("bad");
const filter = document.getElementById("filter"), heads = find("th"), cards = find("article"), rows = find("tbody tr");
const cells = rows.map((row) => [...row.children].map((cell) => cell.dataset.v ?? cell.textContent));
const number = (text) => (text.trim() === "" ? NaN : Number(text));
let descending = false;

// Empty cells last, whatever the direction; equal ones in the order of the input.
function compare(a, b, column) {
  const x = cells[a][column], y = cells[b][column];
  if (x === "" || y === "") return (x === "") - (y === "") || a - b;
  const p = number(x), q = number(y);
  const order = Number.isNaN(p) || Number.isNaN(q) ? x.localeCompare(y, undefined, { numeric: true }) : p - q;
  return (descending ? -order : order) || a - b;
}

function update() {
  const column = Number(by.value), words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
  const order = rows.map((_, i) => i);
  if (column >= 0) order.sort((a, b) => compare(a, b, column));
  else if (descending) order.reverse();
  const values = column < 0 ? [] : cells.map((row) => number(row[column])).filter((value) => value > 0);
  const most = Math.max(...values);
  for (const i of order) {
    cards[i].parentNode.append(cards[i]);
    rows[i].parentNode.append(rows[i]);
    const text = cells[i].join(" ").toLowerCase();
    const out = (bad.checked && rows[i].className === "ok") || !words.every((word) => text.includes(word));
    cards[i].hidden = rows[i].hidden = out;
    const chosen = cards[i].querySelector(".chosen"), cell = column < 0 ? "" : rows[i].children[column].textContent;
    chosen.hidden = column < 1 || cell === "";
    if (column >= 0) chosen.textContent = `${heads[column].textContent}: ${cell}`;
    chosen.style.setProperty("--share", column > 3 && most > 0 ? Math.max(0, number(cells[i][column]) / most) || 0 : 0);
  }
  heads.forEach((head, i) => {
    if (i === column) head.setAttribute("aria-sort", descending ? "descending" : "ascending");
    else head.removeAttribute("aria-sort");
  });
  turn.textContent = descending ? "\u2193" : "\u2191";
}

heads.forEach((head, i) => head.addEventListener("click", () => {
  descending = Number(by.value) === i && !descending;
  by.value = i;
  update();
}));
turn.addEventListener("click", () => { descending = !descending; update(); });
for (const control of [by, bad]) control.addEventListener("change", update);
filter.addEventListener("input", update);
document.querySelector("form").addEventListener("submit", (event) => event.preventDefault());
function show(table) {
  document.getElementById("cards").hidden = table;
  document.getElementById("table").hidden = !table;
  document.getElementById("as-cards").setAttribute("aria-pressed", !table);
  document.getElementById("as-table").setAttribute("aria-pressed", table);
}
document.getElementById("as-cards").addEventListener("click", () => show(false));
document.getElementById("as-table").addEventListener("click", () => show(true));
by.value = "-1";
update();
)js";

}  // namespace quench::program
