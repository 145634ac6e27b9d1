"""The elastic bodies of the blind trials against closed forms and scipy's integrator."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from blind import bodies, elastic


def test_the_free_beam_bends_at_the_ratios_of_the_textbook():
    body = elastic.beam(100.0, 2.0, np.zeros(elastic.MODES))
    roots = np.array([4.730041, 7.853205, 10.995608, 14.137165])  # Blevins, table 8-1
    assert_allclose(body.frequency[2:6], 100.0 * (roots / roots[0]) ** 2, rtol=2e-4)
    gamma = np.linalg.lstsq(body.shapes, np.ones(len(body.shapes)), rcond=None)[0]
    assert np.sum(gamma[:2] ** 2) == pytest.approx(2.0, rel=1e-6)  # the mass of the beam


@pytest.mark.long
@pytest.mark.parametrize("kind", ["gap", "cubic_stiffness"])
def test_its_motion_is_that_of_another_integrator(kind, monkeypatch):
    monkeypatch.setattr(elastic, "SECONDS", 1.2)
    for module in (bodies, elastic):
        monkeypatch.setattr(module, "MODES", 5)
    drawn = replace(elastic.draw(3, kind), sweep=False)
    _, _, force = elastic._moved(drawn, 2)
    wave, rate = elastic._drive(drawn, 2), elastic.RATE * elastic.SUBSTEPS
    foot = drawn.body.shapes[list(drawn.feet)]
    omega = 2.0 * np.pi * drawn.body.frequency
    stiff = np.diag(omega**2) + foot.T @ np.diag(drawn.stiffness) @ foot
    turned = np.linalg.eigh(stiff)[1]  # modes on their feet, in which the body is damped
    own = (turned**2).T @ (2.0 * drawn.body.ratio * omega)
    damp = turned @ np.diag(own) @ turned.T + foot.T @ np.diag(drawn.damping) @ foot
    base = np.linalg.lstsq(drawn.body.shapes, np.ones(len(drawn.body.shapes)), rcond=None)[0]
    at, (size, clearance) = foot[drawn.at], drawn.numbers

    def slope(t, y):
        q, v = y[:5], y[5:]
        z = at @ q
        push = size * (z - min(max(z, -clearance), clearance)) if clearance else size * z**3
        given = wave[min(int(t * rate), wave.size - 1)]  # held over each step
        return np.concatenate([v, -stiff @ q - damp @ v - at * push - base * given])

    times = (np.arange(force.shape[1]) + 0.5) / elastic.RATE
    found = solve_ivp(
        slope, (0.5, 1.2), np.zeros(10), "RK45", times[times > 0.5], rtol=1e-6, atol=1e-12,
        max_step=2.0 / rate,
    )  # fmt: skip
    z = at @ found.y[:5]
    assert_allclose(force[1, times > 0.5], z, atol=0.03 * np.abs(z).max())
