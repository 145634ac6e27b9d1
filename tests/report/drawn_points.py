"""What a browser draws of a page, point by point, against the plots the page was made of."""

import html
from contextlib import contextmanager

import numpy as np
import pytest

from shakerproc.report.figures import figure
from shakerproc.report.figures.figure import Filling

HOOK = """(async () => {
  for (const box of [...alive.keys()]) rest(box);
  const out = [], seen = { marks: [], steps: [] };
  const hook = (of, name, note) => {
    const before = of[name];
    of[name] = function (...given) { note(given, this); return before.apply(this, given); };
    return () => { of[name] = before; };
  };
  const canvas = CanvasRenderingContext2D.prototype;
  const off = [
    hook(canvas, "translate", ([x, y], g) => { if (x !== 0 || y !== 0) seen.place = [x, y]; }),
    hook(canvas, "fill", ([path]) => {
      if (path && seen.place) seen.marks.push(seen.place);
      seen.place = null;
    }),
    hook(canvas, "arc", ([x, y]) => seen.marks.push([x, y])),
    hook(Path2D.prototype, "lineTo", (at) => seen.steps.push(at)),
    hook(Path2D.prototype, "moveTo", (at) => seen.steps.push(at)),
  ];
  const frame = () => new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)));
  for (const data of document.querySelectorAll(".draw > data")) {
    seen.marks = []; seen.steps = [];
    const box = data.parentElement;
    waken(box);
    await frame();
    const u = alive.get(box);
    if (u) out.push({ value: data.value, box: u.bbox, marks: seen.marks, steps: seen.steps,
      kinds: read(data).curves.map(c => c.kind) });
    rest(box);
  }
  off.forEach(end => end());
  return out;
})()"""


@contextmanager
def noted_plots():
    """Yield the plots that are written into pages in the block, by what stands in the page."""
    plots, payload = {}, figure.payload

    def noting(plot):
        written = payload(plot)
        value = html.unescape(str(written)).removeprefix("<data value='")
        plots[value.removesuffix("'></data>")] = plot
        return written

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure, "payload", noting)
        yield plots


def drawn(browser):
    """Return what the browser draws of every live figure of its page."""
    return browser.run(HOOK)


def _shares(axis, values):
    low, high = axis.low, axis.high
    if axis.logarithmic:
        values = np.log(np.where(values > 0.0, values, np.nan))
        low, high = np.log(low), np.log(high)
    return (values - low) / (high - low)


def _inside(plot, item, rows):
    """Return the points of an item between the axes, as shares of both [-]."""
    x = np.concatenate([item.x] * len(rows))
    shares = np.array([_shares(plot.x, x), _shares(plot.y, np.concatenate(rows))]).T
    return shares[np.all((shares >= 0.0) & (shares <= 1.0), axis=1)]


def lost(figure, plot):
    """Return how many points of a plot a figure does not show: marks, and ends of lines.

    Every mark needs one of its own; a line has to pass within two pixels of every point, by the
    points that it is drawn through where there are fewer than the canvas has columns.
    """
    box = figure["box"]

    def places(shares):
        across = box["left"] + shares[:, 0] * box["width"]
        return np.array([across, box["top"] + (1.0 - shares[:, 1]) * box["height"]]).T

    marks = np.array(figure["marks"] or np.zeros((0, 2)), dtype=float)
    steps = np.array(figure["steps"] or np.zeros((0, 2)), dtype=float)
    wanted = []
    missing = 0
    for item in plot.items:
        rows = [item.low, item.high] if isinstance(item, Filling) else [item.y]
        at = places(_inside(plot, item, rows))
        if not isinstance(item, Filling) and (item.points or item.dots):
            wanted.extend(at)
        elif at.size and item.x.size < box["width"]:
            apart = np.min(np.max(np.abs(at[:, None] - steps[None]), axis=2), axis=1)
            missing += int(np.sum(apart > 2.0))
    free = np.ones(len(marks), dtype=bool)
    for place in wanted:
        near = free & np.all(np.abs(marks - place) < 2.0, axis=1)
        if near.any():
            free[np.argmax(near)] = False
        else:
            missing += 1
    return missing
