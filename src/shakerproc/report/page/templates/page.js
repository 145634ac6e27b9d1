"use strict";
// The table of all runs: sorted by its headings, filtered by words and by choices.
const table0 = document.getElementById("all");
const rows = table0 ? Array.from(table0.tBodies[0].rows) : [];
const filter = document.getElementById("filter");
function value(row, column) {
  const cell = row.cells[column];
  const text = cell.dataset.v ?? cell.textContent.trim();
  return text === "" ? null : isNaN(text) ? text.toLowerCase() : Number(text);
}
function compare(a, b) {
  if (a === null || b === null) return (a === null) - (b === null);
  if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
  return a < b ? -1 : a > b ? 1 : 0;
}
function sort(header) {
  const up = header.getAttribute("aria-sort") !== "ascending";
  for (const other of table0.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  header.setAttribute("aria-sort", up ? "ascending" : "descending");
  const column = header.cellIndex;
  const key = new Map(rows.map((row) => [row, value(row, column)]));
  rows.sort((a, b) => {
    const x = key.get(a), y = key.get(b);
    const order = compare(x, y);
    return x === null || y === null || up ? order : -order;
  });
  table0.tBodies[0].append(...rows);
}
if (table0) {
  for (const header of table0.tHead.rows[0].cells) {
    header.tabIndex = 0;
    header.addEventListener("click", () => sort(header));
    header.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") { event.preventDefault(); sort(header); }
    });
  }
  const head = document.createElement("th");
  head.textContent = "overlay";
  head.scope = "col";
  head.className = "picks";
  table0.tHead.rows[0].prepend(head);
  for (const row of rows) {
    const cell = document.createElement("td"), link = row.querySelector("a");
    if (link && document.getElementById(link.getAttribute("href").slice(1))?.querySelector("data")) {
      const pick = document.createElement("input");
      pick.type = "checkbox";
      pick.className = "pick";
      pick.setAttribute("aria-label", `lay test ${link.textContent} over others`);
      cell.append(pick);
    }
    cell.className = "picks";
    row.prepend(cell);
  }
}
const choices = [];
// What a cell can be chosen by: its parts, but for how much of a recording there is.
function parts(row, column) {
  return row.cells[column].textContent.split(", ").map((part) => part.trim())
    .filter((part) => part && !/^[\d.]+ of /.test(part));
}
const ORDER = { "<": (a, b) => a < b, ">": (a, b) => a > b, "<=": (a, b) => a <= b, ">=": (a, b) => a >= b, "=": (a, b) => a === b };
// A word of the filter as a test of a row: text that it holds, or a column against a number.
function wanted(word) {
  const said = /^([^<>=]+)(<=|>=|<|>|=)([-\d.e]+)$/.exec(word);
  const head = said && Array.from(table0.tHead.rows[0].cells)
    .find((cell) => (cell.dataset.name ?? "").toLowerCase().split(" ")[0] === said[1]);
  if (!head) return (row) => row.textContent.toLowerCase().includes(word);
  return (row) => ORDER[said[2]](parseFloat(row.cells[head.cellIndex].textContent), Number(said[3]));
}
function choose() {
  const tests = filter.value.toLowerCase().split(/\s+/).filter(Boolean).map(wanted);
  let shown = 0;
  for (const row of rows) {
    row.hidden = !tests.every((test) => test(row))
      || !choices.every(({ select, column }) => !select.value || parts(row, column).includes(select.value));
    shown += row.hidden ? 0 : 1;
  }
  const all = shown === rows.length;
  document.getElementById("shown").textContent = all ? "" : `${shown} of ${rows.length}`;
}
if (filter) {
  filter.addEventListener("input", choose);
  for (const header of table0.tHead.rows[0].cells) {
    if (!header.dataset.choice) continue;
    const column = header.cellIndex;
    const told = [...new Set(rows.flatMap((row) => parts(row, column)))].sort();
    if (told.length < 1 || told.length > 30 || (told.length === 1 && rows.every((row) => parts(row, column).length))) continue;
    const select = document.createElement("select");
    select.setAttribute("aria-label", header.dataset.name);
    select.add(new Option(`any ${header.dataset.name}`, ""));
    for (const text of told) select.add(new Option(text, text));
    select.addEventListener("change", choose);
    choices.push({ select, column });
    document.getElementById("choices").append(select);
  }
}
// A watched page loads itself again, but not under the hands of its reader.
const refresh = Number(document.body.dataset.refresh ?? 0) * 1000;
const QUIET = 30000; // after the last touch [ms]
if (refresh) {
  let touched = -QUIET;
  for (const kind of ["pointerdown", "keydown", "wheel", "input"]) {
    addEventListener(kind, () => { touched = performance.now(); }, { passive: true });
  }
  setInterval(() => { if (performance.now() - touched >= QUIET) location.reload(); }, refresh);
}
