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
function choose() {
  const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
  let shown = 0;
  for (const row of rows) {
    const text = row.textContent.toLowerCase();
    row.hidden = !words.every((word) => text.includes(word))
      || !choices.every(({ select, column }) => !select.value || row.cells[column].textContent.trim() === select.value);
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
    const told = [...new Set(rows.map((row) => row.cells[column].textContent.trim()))].filter(Boolean).sort();
    if (told.length < 2 || told.length > 30) continue;
    const select = document.createElement("select");
    select.setAttribute("aria-label", header.dataset.name);
    select.add(new Option(`any ${header.dataset.name}`, ""));
    for (const text of told) select.add(new Option(text, text));
    select.addEventListener("change", choose);
    choices.push({ select, column });
    document.getElementById("choices").append(select);
  }
}
