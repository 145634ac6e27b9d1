"""``python -m tests.kernels``: compile what tests in two processes would both compile."""

import numpy as np
from blind.campaigns import draw

from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.simulation import first_calls, simulate
from shakerproc.simulation.harmonic_balance.response import frequency_response
from shakerproc.spectra import swept_response
from tests.harmonic_balance.oscillators import duffing, gap


def main():
    """Draw a hidden campaign, simulate a law without series, balance two, follow a sweep.

    Laws with memory are asked for their force, too.
    """
    draw(11, "gap")
    first_calls.call_along()
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


if __name__ == "__main__":
    main()
