"""``python -m tests.kernels``: compile what tests in two processes would both compile."""

import numpy as np
from blind.campaigns import draw

from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.simulation import simulate


def main():
    """Have a hidden campaign drawn, and a law simulated that has no series."""
    draw(11, "gap")
    law = EFFECTS["power_law"](force=10.0, reference_displacement=1e-3, exponent=1.5)
    element = Element(law, ("base", "coupon"))
    model = Model("law", {"coupon": 1.0}, (element,), Excitation("base acceleration"), {})
    simulate(model, np.random.default_rng(1).standard_normal(100), 500.0, growth=False)


if __name__ == "__main__":
    main()
