"""Scatter over fits that leave out a part, where the scatter is made by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.modal.output_only import jackknife
from shakerproc.modal.stabilisation import OrderPoles, diagram_of

POLE = 2.0 * np.pi * 50.0 * (-0.01 + 1j * np.sqrt(1.0 - 0.01**2))
SHAPE = np.array([[1.0 + 0j, -0.5]])


def fit(order, poles, shapes=SHAPE):
    return OrderPoles(
        order, np.asarray(poles, dtype=complex), np.asarray(shapes, dtype=complex)
    )


@pytest.fixture
def diagram():
    return diagram_of([fit(order, [POLE]) for order in (2, 4, 6, 8)], (10.0, 100.0))


def scatter(diagram, others):
    return jackknife(others, diagram, np.array([POLE]), SHAPE, np.ones(2))


def test_the_middle_over_the_orders_of_a_mode_scatters_over_the_blocks(diagram):
    """A block's own change of frequency is that of its middle order, not that of any one."""
    shifts = np.linspace(-0.001, 0.002, 12)
    others = [
        [
            fit(order, [POLE * (1.0 + one + more)])
            for order, more in ((4, -1e-3), (6, 0), (8, 1e-3))
        ]
        for one in shifts
    ]
    errors, chance = scatter(diagram, others)
    values = np.log1p(shifts)
    wanted = np.sqrt(11.0 / 12.0 * np.sum((values - values.mean()) ** 2))
    assert_allclose(errors[1], wanted, rtol=1e-9)
    assert_allclose(errors[0], 0.0, atol=1e-12)
    assert_allclose(chance, 0.0, atol=1e-24)


def test_imaginary_parts_scatter_in_the_size_of_the_shape(diagram):
    turns = np.linspace(-0.02, 0.02, 12)
    others = [[fit(4, [POLE], SHAPE * [1.0, np.exp(1j * one)])] for one in turns]
    _, chance = scatter(diagram, others)
    mean_phase = 0.2 * turns  # of squares 1 and 0.25, weighted: small angles
    imaginary = np.stack([-mean_phase, -0.5 * (turns - mean_phase)])
    assert_allclose(chance[0], 11.0 / 12.0 * np.sum(imaginary**2, axis=1), rtol=1e-3)


def test_a_block_without_which_no_order_has_a_pole_leaves_nothing_known(diagram):
    others = [[fit(4, [POLE])], [fit(4, [], np.zeros((0, 2))), fit(9, [POLE])]]
    errors, _ = scatter(diagram, others)
    assert np.isnan(errors).all()
