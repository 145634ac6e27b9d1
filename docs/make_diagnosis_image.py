"""Draw docs/images/diagnosis_idea.svg: python docs/make_diagnosis_image.py.

A mass on a joint with play, driven at its base. The integrator shares no code with the program.
"""

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np
from scipy import optimize, signal

DRAWING = Path(__file__).resolve().parent / "images" / "diagnosis_idea.svg"
RATE = 5120.0  # of samples and of steps [Hz]
MASS = 0.0286  # [kg]
TRUTH = np.array([37e3, 2.6, 50e3, 0.05e-3])  # spring [N/m], damper [N s/m], contact, clearance
HELD_OUT_S, END_S = 0.6, 0.9  # the second part takes no part in a fit
SHOWN_S = (0.555, 0.645)
NOISE = 0.4  # rms of the sensor's noise [m/s^2]
WIDTH, HEIGHT, LEFT, TOP, PANEL, GAP = 760, 492, 20, 44, 100, 42  # of the drawing [px]
MEASURED, MODELLED = "#222222", "#d1570a"


def response(base: np.ndarray, numbers: Sequence[float]) -> np.ndarray:
    """Return the acceleration of the mass [m/s^2] under that of its base [m/s^2], from rest."""
    stiffness, damping, contact, clearance = numbers
    step, place, speed = 1.0 / RATE, 0.0, 0.0
    middle = 0.5 * (base[:-1] + base[1:])

    def pull(z: float, v: float) -> float:
        beyond = max(abs(z) - clearance, 0.0) * (1.0 if z > 0.0 else -1.0)
        return -(stiffness * z + damping * v + contact * beyond) / MASS

    out = np.zeros(base.size)
    for i in range(base.size - 1):  # classical Runge-Kutta steps
        a1 = pull(place, speed) - base[i]
        v2 = speed + 0.5 * step * a1
        a2 = pull(place + 0.5 * step * speed, v2) - middle[i]
        v3 = speed + 0.5 * step * a2
        a3 = pull(place + 0.5 * step * v2, v3) - middle[i]
        v4 = speed + step * a3
        a4 = pull(place + step * v3, v4) - base[i + 1]
        place += step * (speed + 2.0 * v2 + 2.0 * v3 + v4) / 6.0
        speed += step * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0
        out[i + 1] = pull(place, speed)
    return out


def fitted(base: np.ndarray, measured: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return the free run with numbers fitted by least squares to what is not held out."""
    n = int(HELD_OUT_S * RATE)

    def run(logs: np.ndarray, samples: int) -> np.ndarray:
        contact = [0.0, 1.0] if logs.size == 2 else []
        return response(base[:samples], [*(start[: logs.size] * np.exp(logs)), *contact])

    found = optimize.least_squares(
        lambda logs: run(logs, n) - measured[:n], np.zeros(start.size), diff_step=1e-4
    )
    return run(found.x, base.size)


def error(measured: np.ndarray, modelled: np.ndarray) -> float:
    """Return the rms of the residual over that of the measurement, of what was held out [-]."""
    part = slice(int(HELD_OUT_S * RATE), None)
    return float(
        np.sqrt(np.mean((measured - modelled)[part] ** 2) / np.mean(measured[part] ** 2))
    )


def line(values: np.ndarray, top: float, largest: float, style: str) -> str:
    """Return samples as a line in a panel; `largest` is half the height of the panel."""
    first, last = (int(s * RATE) for s in SHOWN_S)
    x = np.linspace(LEFT, WIDTH - LEFT, last - first)
    y = top + 0.5 * PANEL * (1.0 - values[first:last] / largest)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    return f'<polyline points="{points}" fill="none" {style}/>'


def text(x: float, y: float, words: str, more: str = "") -> str:
    """Return words at a place."""
    return f'<text x="{x:.0f}" y="{y:.0f}" {more}>{escape(words)}</text>'


def main() -> None:
    """Draw the input, and the measured response with the free runs of two models."""
    random = np.random.default_rng(5)
    n = int(END_S * RATE)
    band = signal.butter(4, [20.0, 500.0], "bandpass", fs=RATE, output="sos")
    base = signal.sosfilt(band, random.standard_normal(n))
    base *= 40.0 / np.std(base)
    measured = response(base, TRUTH) + NOISE * random.standard_normal(n)
    linear = fitted(base, measured, TRUTH[:2] * [1.1, 0.75])
    with_gap = fitted(base, measured, TRUTH * [0.9, 1.3, 1.2, 0.9])
    solid, dashed = (
        f'stroke="{MEASURED}" stroke-width="1.6"',
        f'stroke="{MODELLED}" stroke-width="1.8" stroke-dasharray="6 3"',
    )
    panels = (
        ("1. The measured input drives the model.", base, None),
        ("2. Without the effect: free run and measurement disagree.", measured, linear),
        ("3. With a gap in the joint: the free run follows.", measured, with_gap),
    )
    middle = LEFT + (WIDTH - 2 * LEFT) * (HELD_OUT_S - SHOWN_S[0]) / (SHOWN_S[1] - SHOWN_S[0])
    bottom = TOP + 3 * PANEL + 3 * GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="14">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        f'<rect x="{middle:.0f}" y="{TOP - 16}" width="{WIDTH - LEFT - middle:.0f}" '
        f'height="{bottom - TOP}" fill="#e8f0f8"/>',
        text(0.5 * (LEFT + middle), 20, "fitted", 'text-anchor="middle" font-weight="bold"'),
        text(
            0.5 * (middle + WIDTH - LEFT), 20, "held out: only predicted",
            'text-anchor="middle" font-weight="bold"',
        ),
    ]  # fmt: skip
    for i, (title, values, modelled) in enumerate(panels):
        top = TOP + i * (PANEL + GAP) + 14
        largest = 1.05 * float(np.max(np.abs(values[slice(*(int(s * RATE) for s in SHOWN_S))])))
        parts += [text(LEFT + 4, top - 8, title), line(values, top, largest, solid)]
        if modelled is not None:
            parts.append(line(modelled, top, largest, dashed))
            told = f"held-out error {error(values, modelled):.2g}"
            parts.append(text(WIDTH - LEFT - 4, top - 8, told, 'text-anchor="end"'))
    y = HEIGHT - 14
    parts += [
        f'<line x1="{LEFT}" x2="{LEFT + 40}" y1="{y - 5}" y2="{y - 5}" {solid}/>',
        text(LEFT + 48, y, "measured"),
        f'<line x1="{LEFT + 150}" x2="{LEFT + 190}" y1="{y - 5}" y2="{y - 5}" {dashed}/>',
        text(LEFT + 198, y, "model, simulated from rest (free run)"),
        text(WIDTH - LEFT, y, "time: 0.09 s in all", 'text-anchor="end"'),
        "</svg>\n",
    ]
    DRAWING.write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
