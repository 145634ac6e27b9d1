// Drawings anew, for whoever looks closer: zoom, read-out, curves on and off. Every drawing has
// its SVG below; this only lies on top of it while it is on the screen, and never when printed.
const look = JSON.parse(document.body.dataset.look);
const LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
const DIGIT = new Uint8Array(128);
for (let i = 0; i < 64; i++) DIGIT[LETTERS.charCodeAt(i)] = i;
const dark = matchMedia("(prefers-color-scheme: dark)");
const LINE = 0, THIN = 1, WIDE = 2, MARKS = 3, DOTS = 4, AREA = 5;

function values(text, axis, places) {
  const top = 64 ** places - 1, n = text.length / places, out = new Array(n);
  const low = axis.log ? Math.log(axis.least) : axis.least;
  const high = axis.log ? Math.log(axis.most) : axis.most;
  for (let i = 0; i < n; i++) {
    let step = 0;
    for (let k = 0; k < places; k++) step = step * 64 + DIGIT[text.charCodeAt(i * places + k)];
    const at = low + (step / (top - 1)) * (high - low);
    out[i] = step === top ? null : axis.log ? Math.exp(at) : at;
  }
  return out;
}
function places(content, axis, curves) {
  if (typeof content === "number") return curves[content].x;
  if (typeof content === "string") return values(content, axis, 3);
  const [first, last, n] = content;
  return Array.from({ length: n }, (_, i) => first + ((last - first) * i) / (n - 1));
}
function axisOf([label, low, high, log, least, most]) {
  return { label, low, high, log: log === 1, degrees: log === 2, least, most };
}
// What the element beside a drawing says, as curves of numbers.
function read(element) {
  const content = JSON.parse(element.value);
  const x = axisOf(content.x), y = axisOf(content.y), curves = [];
  for (const [label, style, kind, at, ...rows] of content.c) {
    const hollow = kind === MARKS ? rows[1] ?? [] : [];
    const curve = { label, style, kind, hollow, x: places(at, x, curves), y: values(rows[0], y, 2),
      low: kind === AREA ? values(rows[1], y, 2) : null };
    const half = kind === MARKS ? rows[2] ?? [] : [];
    curve.bars = new Map(half.map((h, i) => [`${curve.x[i]} ${curve.y[i]}`, h]));
    curves.push(curve);
  }
  curves.forEach((c, i) => {
    const near = [curves[i - 1], curves[i + 1]].find((o) => o && o.style === c.style && o.label);
    c.name = c.label || (near ? near.label : "");
  });
  const image = content.i && surfaceOf(element, content.i);
  return { x, y, curves, marks: content.m ?? [], spans: content.s ?? [], spread: content.e, image };
}
// The picture behind a drawing: it fills the axes; its colours are steps of a level.
function surfaceOf(element, [low, high, label]) {
  const picture = new Image(), surface = { picture, label, level: () => null };
  picture.onload = () => {
    const canvas = document.createElement("canvas"), { width, height } = picture;
    canvas.width = width;
    canvas.height = height;
    const g = canvas.getContext("2d");
    g.drawImage(picture, 0, 0);
    const dots = g.getImageData(0, 0, width, height).data, step = new Map();
    look.steps.forEach((colour, i) => step.set(parseInt(colour.slice(1), 16), i));
    surface.level = (across, down) => {
      const column = Math.min(width - 1, Math.max(0, Math.floor(across * width)));
      const row = Math.min(height - 1, Math.max(0, Math.floor(down * height)));
      const at = 4 * (row * width + column);
      const i = step.get(dots[at] * 65536 + dots[at + 1] * 256 + dots[at + 2]);
      return low + ((high - low) * i) / (look.steps.length - 1);
    };
    surface.drawn?.redraw();
  };
  picture.src = element.parentElement.querySelector("image").getAttribute("href");
  return surface;
}
function shown(value, digits) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size < 1e-3 || size >= 1e6 ? value.toExponential(digits - 1)
    : String(Number(value.toPrecision(digits)));
  return text.replace("e-", "e−").replace(/^-/, "−");
}
const UP = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
function tick(value, log) {
  if (value === null) return null;
  const power = Math.log10(Math.abs(value));
  if (log && (power < -2 - 1e-6 || power > 3.5)) {
    const whole = Math.floor(power + 1e-6), first = value / 10 ** whole;
    const ten = "10" + Array.from(String(whole), (c) => UP[c]).join("");
    return Math.abs(first - 1) < 1e-6 ? ten : `${Number(first.toPrecision(3))}·${ten}`;
  }
  return log ? shown(value, 3) : String(Number(value.toPrecision(10))).replace("-", "−");
}
// Where a logarithmic axis is marked: powers of ten, then 1, 2, 5 of each, then even steps.
function marked(_u, _axis, low, high) {
  const decades = Math.log10(high / low), out = [];
  if (decades < 0.7) {
    const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
    for (let i = Math.ceil(low / step); i <= high / step; i++) out.push(i * step);
    return out;
  }
  const every = Math.max(1, Math.ceil(decades / 7));
  for (let p = Math.floor(Math.log10(low)); p <= Math.ceil(Math.log10(high)); p++) {
    for (const m of decades > 2.5 ? [1] : [1, 2, 5]) {
      const value = m * 10 ** p;
      if (value >= low * 0.9999 && value <= high * 1.0001 && (m > 1 || p % every === 0)) out.push(value);
    }
  }
  return out;
}
// One table with a column for each curve: the script that draws wants the same x for all. A place
// has as many rows as the curve that has most points there, so that none covers another.
function table(curves) {
  const queues = new Map(), columns = [], x = [];
  for (const c of curves) {
    const rows = c.low ? [c.y, c.low] : c.kind !== MARKS || !c.hollow.length ? [c.y]
      : [c.y.map((v, i) => (c.hollow.includes(i) ? null : v)),
         c.y.map((v, i) => (c.hollow.includes(i) ? v : null))];
    if (!queues.has(c.x)) queues.set(c.x, { of: c.x, order: rising(c.x), next: 0, taken: [] });
    for (const row of rows) columns.push({ row, queue: queues.get(c.x) });
  }
  for (;;) {
    let least = Infinity;
    for (const { of, order, next } of queues.values()) {
      if (next < order.length) least = Math.min(least, of[order[next]]);
    }
    if (least === Infinity) break;
    x.push(least);
    for (const queue of queues.values()) {
      const i = queue.order[queue.next], here = queue.of[i] === least;
      queue.taken.push(here ? i : -1);
      queue.next += here;
    }
  }
  return [x, ...columns.map(({ row, queue }) => broken(queue.taken.map((i) => (i < 0 ? undefined : row[i]))))];
}
// The order in which places rise; of a line that falls, back along it.
function rising(places) {
  const order = places.map((_, i) => i);
  if (places[0] > places.at(-1)) order.reverse();
  return order.sort((a, b) => places[a] - places[b]);
}
// A line that is broken stays so up to its next value, whatever others have between.
function broken(column) {
  column.forEach((value, i) => {
    if (value !== null) return;
    for (const step of [-1, 1]) for (let j = i + step; column[j] === undefined && j in column; j += step) column[j] = null;
  });
  return column;
}
function dashed(dash) {
  return dash ? dash.split(" ").map(Number) : [];
}
// How far a value may be off, drawn behind its mark.
function barred(u, g, x, at, half, ratio) {
  const [low, high] = [at - half, at + half].map((v) => u.valToPos(v, "y", true)), cap = 3 * ratio;
  g.beginPath();
  for (const [a, b, c, d] of [[x, low, x, high], [x - cap, low, x + cap, low], [x - cap, high, x + cap, high]]) {
    g.moveTo(a, b);
    g.lineTo(c, d);
  }
  g.lineWidth = ratio;
  g.stroke();
}
function pointed(path, size, colour, hollow, bars) {
  return (u, at, from, to) => {
    const g = u.ctx, ratio = uPlot.pxRatio, box = u.bbox, mark = new Path2D(path);
    g.save();
    g.beginPath();
    g.rect(box.left, box.top, box.width, box.height);
    g.clip();
    g.fillStyle = hollow ? "#fff" : colour;
    g.strokeStyle = colour;
    for (let i = from; i <= to; i++) {
      if (u.data[at][i] === null || u.data[at][i] === undefined) continue;
      const x = u.valToPos(u.data[0][i], "x", true), y = u.valToPos(u.data[at][i], "y", true);
      if (!path) {
        g.beginPath();
        g.arc(x, y, (size * ratio) / 2, 0, 7);
        g.fill();
        continue;
      }
      const half = bars?.get(`${u.data[0][i]} ${u.data[at][i]}`);
      if (half) barred(u, g, x, u.data[at][i], half, ratio);
      g.save();
      g.translate(x, y);
      g.scale(ratio / 4, ratio / 4);
      g.fill(mark);
      if (hollow) { g.lineWidth = 6; g.stroke(mark); }
      g.restore();
    }
    g.restore();
    return false;
  };
}
function seriesOf(curve, index) {
  const style = curve.style % look.colours.length, colour = curve.colour ?? look.colours[style];
  const grey = curve.kind === WIDE || (curve.kind === DOTS && style === 7);
  const stroke = grey ? "#a9a9a9" : colour;
  const base = { label: curve.name, stroke, width: 1.35, points: { show: false },
    dash: dashed(curve.dash ?? look.dashes[style]) };
  if (curve.kind === THIN) return [{ ...base, width: 1 }];
  if (curve.kind === WIDE) return [{ ...base, width: 3.7, dash: [] }];
  if (curve.kind === AREA) return [{ ...base, width: 0.5, dash: [] }, { ...base, width: 0.5, dash: [] }];
  if (curve.kind === LINE) return [base];
  const none = { ...base, paths: () => null };
  const draw = (hollow) => ({ show: curve.kind === DOTS ? pointed("", grey ? 4 : 2.4, stroke, false)
    : pointed(look.markers[style % look.markers.length], 0, stroke, hollow, curve.bars) });
  return curve.hollow.length ? [{ ...none, points: draw(false) }, { ...none, points: draw(true) }]
    : [{ ...none, points: draw(false) }];
}
function nearest(x, at) {
  let best = 0, least = Infinity;
  for (let i = 0; i < x.length; i++) {
    const off = Math.abs(x[i] - at);
    if (off < least) { least = off; best = i; }
  }
  return best;
}
function readOut(figure, hidden) {
  const box = document.createElement("div");
  box.className = "read";
  box.hidden = true;
  return {
    hooks: {
      init: [(u) => u.over.append(box)],
      setCursor: [(u) => {
        const { left, top } = u.cursor;
        box.hidden = left === null || left < 0;
        if (box.hidden) return;
        const at = u.posToVal(left, "x");
        const lines = [`${figure.x.label.replace(/ \[.*/, "")} ${shown(at, 4)} ${unit(figure.x.label)}`];
        if (figure.image) {
          const up = u.posToVal(top, "y"), { x, y } = figure;
          const level = figure.image.level((at - x.low) / (x.high - x.low), (y.high - up) / (y.high - y.low));
          lines.push(`${y.label.replace(/ \[.*/, "")} ${shown(up, 3)} ${unit(y.label)}`, `${shown(level, 3)} ${figure.image.label}`);
        } else if (figure.curves.some((c) => c.kind === DOTS)) {
          lines.push(`${figure.y.label.replace(/ \[.*/, "")} ${shown(u.posToVal(top, "y"), 3)} ${unit(figure.y.label)}`);
        } else {
          const first = figure.curves.find((c) => !hidden.has(c.name) && c.kind !== THIN);
          if (first) lines[0] = `${figure.x.label.replace(/ \[.*/, "")} ${shown(first.x[nearest(first.x, at)], 5)} ${unit(figure.x.label)}`;
          for (const c of figure.curves) {
            if (!c.label || hidden.has(c.name) || (c.kind !== MARKS && c.x.length < 3)) continue;
            const i = nearest(c.x, at);
            const here = c.kind === MARKS ? c.y.filter((_, j) => c.x[j] === c.x[i]) : [c.y[i]];
            lines.push(`${c.label}: ${c.low ? `${shown(c.low[i], 3)} to ` : ""}${here.map((v) => shown(v, 3)).join(", ")}`);
          }
          if (unit(figure.y.label)) lines[0] += `; ${unit(figure.y.label)}:`;
        }
        box.textContent = lines.slice(0, 14).join("\n");
        box.classList.toggle("left", left > u.over.clientWidth / 2);
      }],
    },
  };
}
function unit(label) {
  const found = /\[(.*)\]/.exec(label);
  return found && found[1] !== "-" ? found[1] : "";
}
function shading(figure) {
  const across = (u, value) => u.valToPos(value, "x", true);
  return {
    hooks: {
      drawClear: [(u) => {
        const { left, top, width, height } = u.bbox;
        u.ctx.save();
        u.ctx.beginPath();
        u.ctx.rect(left, top, width, height);
        u.ctx.clip();
        u.ctx.fillStyle = "#eceef0";
        for (const [low, high] of figure.spans) {
          u.ctx.fillRect(across(u, low), top, across(u, high) - across(u, low), height);
        }
        u.ctx.restore();
      }],
      drawAxes: [(u) => {
        if (!figure.image?.picture.complete) return;
        const { left, top, width, height } = u.bbox, { x, y, image } = figure;
        const up = (value) => u.valToPos(value, "y", true);
        u.ctx.save();
        u.ctx.beginPath();
        u.ctx.rect(left, top, width, height);
        u.ctx.clip();
        u.ctx.imageSmoothingEnabled = false;
        if (dark.matches) u.ctx.filter = "invert(1) hue-rotate(180deg)"; // as the whole figure is
        u.ctx.drawImage(image.picture, across(u, x.low), up(y.high), across(u, x.high) - across(u, x.low), up(y.low) - up(y.high));
        u.ctx.restore();
      }],
      draw: [(u) => {
        const { left, top, width, height } = u.bbox, ratio = uPlot.pxRatio, g = u.ctx;
        g.save();
        g.strokeStyle = g.fillStyle = "#000";
        g.lineWidth = ratio;
        g.font = `600 ${11 * ratio}px system-ui, sans-serif`;
        g.setLineDash([4 * ratio, 3 * ratio]);
        for (const [value, label] of figure.marks) {
          const x = across(u, value);
          if (x < left || x > left + width) continue;
          g.beginPath();
          g.moveTo(x, top);
          g.lineTo(x, top + height);
          g.stroke();
          const end = x > left + 0.8 * width;
          g.textAlign = end ? "right" : "left";
          g.lineWidth = 3 * ratio;
          g.strokeStyle = "#fff";
          g.setLineDash([]);
          g.strokeText(label, x + (end ? -4 : 4) * ratio, top + 11 * ratio);
          g.lineWidth = ratio;
          g.strokeStyle = "#000";
          g.setLineDash([4 * ratio, 3 * ratio]);
          g.fillText(label, x + (end ? -4 : 4) * ratio, top + 11 * ratio);
        }
        if (figure.spread) {
          const { min, max } = u.scales.y, x = left + width - 10 * ratio, y = top + 8 * ratio;
          const tall = (Math.log(figure.spread) / Math.log(max / min)) * height;
          g.setLineDash([]);
          g.beginPath();
          for (const [a, b] of [[x - 3 * ratio, y], [x - 3 * ratio, y + tall]]) { g.moveTo(a, b); g.lineTo(a + 6 * ratio, b); }
          g.moveTo(x, y);
          g.lineTo(x, y + tall);
          g.stroke();
          g.font = `${11 * ratio}px system-ui, sans-serif`;
          g.textAlign = "right";
          g.fillText("95 %", x - 6 * ratio, y + Math.max(tall / 2 + 4 * ratio, 8 * ratio));
        }
        g.restore();
      }],
    },
  };
}
// Draw a figure over the whole of an element; return what draws it.
function draw(host, figure, hidden, width, height) {
  const series = [{}], bands = [];
  for (const curve of figure.curves) {
    const made = seriesOf(curve);
    if (curve.kind === AREA) {
      const colour = curve.colour ?? look.colours[curve.style % look.colours.length];
      bands.push({ series: [series.length, series.length + 1], fill: `${colour}cc` });
    }
    for (const one of made) series.push({ ...one, scale: "y", show: !hidden.has(curve.name) });
  }
  const scale = ({ low, high, log }) => ({ time: false, auto: false, min: low, max: high,
    distr: log ? 3 : 1, range: (_u, from, to) => [from, to] });
  const axis = (of, size) => ({ stroke: "#333", font: "11px system-ui, sans-serif", size, gap: 4,
    labelFont: "11px system-ui, sans-serif", labelSize: 14, labelGap: 0, label: of.label || undefined,
    grid: { stroke: "#dedede", width: 1 }, ticks: { show: false },
    ...(of.log ? { splits: marked, filter: (_u, splits) => splits } : {}),
    ...(of.degrees ? { incrs: [1, 2, 5, 10, 15, 30, 45, 90, 180], space: 20 } : {}),
    values: (_u, splits) => splits.map((v) => tick(v, of.log)) });
  const whole = (u) => u.batch(() => {
    u.setScale("x", { min: figure.x.low, max: figure.x.high });
    u.setScale("y", { min: figure.y.low, max: figure.y.high });
  });
  const drawn = new uPlot({
    width, height, series, bands, padding: [8, 18, 0, 0],
    scales: { x: scale(figure.x), y: scale(figure.y) },
    axes: [figure.x.label ? axis(figure.x, 20) : { ...axis(figure.x, 6), values: () => [] }, { ...axis(figure.y, 44), side: 3, ...(height < 120 ? { space: 14 } : {}) }],
    legend: { show: false },
    cursor: { points: { show: false }, drag: { x: true, y: true, uni: 25, dist: 4 },
      bind: { dblclick: (u) => () => { whole(u); return null; } } },
    plugins: [shading(figure), readOut(figure, hidden)],
  }, figure.curves.length ? table(figure.curves) : [[figure.x.low, figure.x.high]], host);
  if (figure.image) figure.image.drawn = drawn;
  return drawn;
}
// Every drawing of the page, drawn when scrolled to and left again when far away.
const alive = new Map(), hiddenOf = new WeakMap();
function waken(box) {
  if (alive.has(box)) return;
  const figure = box.closest("figure"), size = box.querySelector("svg").getBoundingClientRect();
  if (size.width < 80) return;
  if (!hiddenOf.has(figure)) hiddenOf.set(figure, new Set());
  alive.set(box, draw(box, read(box.querySelector("data")), hiddenOf.get(figure), size.width, size.height));
  box.classList.add("live");
  toggles(figure);
}
function rest(box) {
  alive.get(box)?.destroy();
  alive.delete(box);
  box.classList.remove("live");
}
function toggles(figure) {
  if (figure.dataset.toggles) return;
  figure.dataset.toggles = "yes";
  for (const key of figure.querySelectorAll(".legend span")) {
    const name = key.textContent.trim();
    const turn = () => {
      const hidden = hiddenOf.get(figure), off = !hidden.has(name);
      if (off) hidden.add(name); else hidden.delete(name);
      key.setAttribute("aria-pressed", String(!off));
      for (const box of figure.querySelectorAll(".draw")) {
        const u = alive.get(box);
        if (!u) continue;
        const { min, max } = u.scales.y;
        u.batch(() => {
          u.series.forEach((s, i) => { if (i > 0 && s.label === name) u.setSeries(i, { show: !off }); });
          u.setScale("y", { min, max });
        });
      }
    };
    key.tabIndex = 0;
    key.setAttribute("role", "button");
    key.setAttribute("aria-pressed", "true");
    key.addEventListener("click", turn);
    key.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") { event.preventDefault(); turn(); }
    });
  }
}
const seen = new IntersectionObserver((entries) => {
  for (const entry of entries) if (entry.isIntersecting) waken(entry.target);
}, { rootMargin: "150px" });
const gone = new IntersectionObserver((entries) => {
  for (const entry of entries) if (!entry.isIntersecting) rest(entry.target);
}, { rootMargin: "1500px" });
for (const data of document.querySelectorAll(".draw > data")) {
  seen.observe(data.parentElement);
  gone.observe(data.parentElement);
}
let resized = 0, before = innerWidth;
addEventListener("resize", () => {
  if (innerWidth === before) return;
  before = innerWidth;
  clearTimeout(resized);
  resized = setTimeout(() => {
    for (const box of [...alive.keys()]) {
      rest(box);
      seen.unobserve(box);
      seen.observe(box);
    }
    overlay();
  }, 150);
});
// Curves of several runs overlaid: those that are ticked in the table.
const KINDS = { psd: "power spectral density", gain: "response over control, |H1|",
  coherence: "coherence with the control", sweep: "swept response", time: "time", level: "level of the control along a sweep" };
let laid = null;
function runOf(row) {
  const link = row.querySelector("a[href^='#run-']");
  return link ? document.getElementById(link.getAttribute("href").slice(1)) : null;
}
// What tells each of these runs from the others: its test, and the facts that are not shared.
function titlesOf(picked) {
  const wanted = ["test", "joint", "specimen", "clearance", "orientation", "excitation", "level"];
  const heads = Array.from(table1.tHead.rows[0].cells, (cell) => cell.dataset.name ?? "");
  const told = (row, i) => row.cells[i].textContent.trim();
  const columns = heads.map((name, i) => i).filter((i) => heads[i] === "test"
    || (wanted.includes(heads[i]) && (picked.length < 2 || picked.some((row) => told(row, i) !== told(picked[0], i)))));
  return picked.map((row) => `test ${columns.map((i) => told(row, i)).filter(Boolean).join(", ")}`);
}
const table1 = document.getElementById("all");
function chosen() {
  return rows.filter((row) => row.querySelector("input.pick")?.checked);
}
function overlay() {
  const place = document.getElementById("overlay");
  if (!place) return;
  laid?.destroy();
  laid = null;
  const picked = chosen();
  place.hidden = picked.length === 0;
  if (place.hidden) return;
  const kind = document.getElementById("overlay-kind").value;
  const channels = document.getElementById("overlay-channel"), wanted = channels.value;
  const found = picked.map((row) => {
    const data = runOf(row)?.querySelectorAll(`figure[data-kind="${kind}"] data`) ?? [];
    return { row, figures: Array.from(data, (one) => read(one)) };
  });
  const names = [...new Set(found.flatMap(({ figures }) => figures.flatMap((f) => f.curves.filter((c) => c.kind !== THIN).map((c) => c.name))))]
    .filter(Boolean);
  const favourite = [wanted, table1.dataset.channel, names[0]].find((name) => names.some((n) => n === name || n.startsWith(`${name} `)));
  channels.replaceChildren(...names.map((name) => new Option(name, name, false,
    name === favourite || (!names.includes(favourite) && name.startsWith(`${favourite} `)))));
  const curves = [], missing = [], titles = titlesOf(picked);
  found.forEach(({ row, figures }, i) => {
    const own = figures.flatMap((f) => f.curves.filter((c) => c.name === channels.value && c.kind !== THIN)
      .map((c) => ({ ...c, of: f })));
    if (!own.length) { missing.push(row.cells[1].textContent.trim()); return; }
    for (const c of own) {
      curves.push({ ...c, name: titles[i], label: titles[i], style: i % 6, colour: look.colours[i % 6],
        dash: look.dashes[(i + Math.floor(i / 6)) % 6] });
    }
  });
  const host = document.getElementById("overlay-plot"), keys = document.getElementById("overlay-keys");
  host.replaceChildren();
  keys.replaceChildren();
  document.getElementById("overlay-note").textContent = missing.length
    ? `No such curve: test ${missing.join(", ")}.` : "";
  if (!curves.length) return;
  const merge = (which) => {
    const all = curves.map((c) => c.of[which]);
    return { ...all[0], low: Math.min(...all.map((a) => a.low)), high: Math.max(...all.map((a) => a.high)) };
  };
  const figure = { x: merge("x"), y: merge("y"), curves, marks: [], spans: [] };
  laid = draw(host, figure, new Set(), host.clientWidth, 380);
  for (const c of curves) {
    const key = document.createElement("span"), line = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    line.setAttribute("class", "key");
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    path.setAttribute("d", "M0 20h96"); // in quarter pixels, as all keys
    path.style.stroke = c.colour;
    path.style.strokeWidth = "6";
    path.style.strokeDasharray = dashed(c.dash).map((step) => 4 * step).join(" ");
    line.append(path);
    key.append(line, ` ${c.label}`);
    keys.append(key);
  }
}
if (table1 && document.querySelector("figure[data-kind] data")) {
  const select = document.getElementById("overlay-kind");
  for (const [kind, name] of Object.entries(KINDS)) {
    if (document.querySelector(`figure[data-kind="${kind}"] data`)) select.add(new Option(name, kind));
  }
  select.addEventListener("change", overlay);
  document.getElementById("overlay-channel").addEventListener("change", overlay);
  document.getElementById("overlay-clear").addEventListener("click", () => {
    for (const row of rows) if (row.querySelector("input.pick")) row.querySelector("input.pick").checked = false;
    overlay();
  });
  document.getElementById("pick-shown").addEventListener("click", () => {
    for (const row of rows) {
      const pick = row.querySelector("input.pick");
      if (pick && !row.hidden) pick.checked = true;
    }
    overlay();
  });
  table1.addEventListener("change", (event) => { if (event.target.matches("input.pick")) overlay(); });
}
for (const hint of document.querySelectorAll(".scripted")) hint.hidden = false;
