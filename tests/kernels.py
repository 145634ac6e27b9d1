"""``python -m tests.kernels PART``: compile what tests in two processes would both compile."""

import sys

import numpy as np

from shakerproc.simulation import first_calls


def more():
    """Compile what only tests need.

    Draw a hidden campaign, simulate a law without series, balance two, follow a sweep.
    """
    from blind.campaigns import draw

    from shakerproc.models import EFFECTS, Element, Excitation, Model
    from shakerproc.simulation import simulate
    from shakerproc.simulation.harmonic_balance.response import frequency_response
    from shakerproc.spectra import swept_response
    from tests.harmonic_balance.oscillators import duffing, gap

    draw(11, "gap")
    law = EFFECTS["power_law"](force=10.0, reference_displacement=1e-3, exponent=1.5)
    element = Element(law, ("base", "coupon"))
    model = Model("law", {"coupon": 1.0}, (element,), Excitation("base acceleration"), {})
    simulate(model, np.random.default_rng(1).standard_normal(100), 500.0, growth=False)
    for one in (gap(5e-3), duffing()):
        frequency_response(one, 0.5, from_hz=3.0, to_hz=3.1, harmonics=3)
    time = np.arange(0.0, 4.0, 1.0 / 512.0)
    swept_response(
        np.array([np.sin(2.0 * np.pi * 20.0 * 2.0 ** (time / 2.0) * time)] * 2),
        512.0,
        [0],
        (20.0, 80.0),
    )


def laws():
    """Compile propagators, and the laws with memory along a motion."""
    first_calls.call_propagators()
    first_calls.call_along()


PARTS = {"laws": laws, "runs": first_calls.call_free_runs_by_series, "more": more}
"""Parts that processes compile side by side; the first two need no package of the tests."""

if __name__ == "__main__":
    PARTS[sys.argv[1]]()
