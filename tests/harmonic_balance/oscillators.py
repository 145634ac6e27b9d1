"""Models for the tests of harmonic balance, and an integrator that shares no code with it."""

import numpy as np
from scipy.integrate import solve_ivp

from shakerproc.models import EFFECTS, Element, Excitation, Model

DAMPING = 2.0 * 0.01 * np.sqrt(1000.0)


def model(*effects, mass=1.0):
    """One mass on the base, shaken by a force."""
    elements = tuple(Element(effect, ("base", "mass")) for effect in effects)
    return Model("test", {"mass": mass}, elements, Excitation("force", "mass"))


def gap(clearance, stiffness=1000.0, damping=DAMPING):
    return model(
        EFFECTS["gap"](stiffness=stiffness, clearance=clearance),
        EFFECTS["damper"](damping=damping),
    )


def duffing(coefficient=1e7, stiffness=1000.0, damping=DAMPING):
    return model(
        EFFECTS["spring"](stiffness=stiffness),
        EFFECTS["cubic_stiffness"](coefficient=coefficient),
        EFFECTS["damper"](damping=damping),
    )


def flow(force, load, omega, state, time, walls=(), mass=1.0):
    """The state after a time under ``load cos(omega t)``, restarted at every wall.

    `force` is a function of displacement, velocity and the stretch between the walls that the
    motion is on, so that no step ever straddles a corner of the law.
    """
    now, state = 0.0, np.array(state)
    stretch = int(np.searchsorted(walls, state[0] + 1e-9 * state[1]))
    while now < time:

        def motion(t, y, stretch=stretch):
            return [y[1], (load * np.cos(omega * t) - force(y[0], y[1], stretch)) / mass]

        events = []
        for i, wall in enumerate(walls):
            if i in {stretch - 1, stretch}:

                def cross(_, y, wall=wall):
                    return y[0] - wall

                cross.terminal, cross.direction = True, (1.0 if i == stretch else -1.0)
                events.append(cross)
        found = solve_ivp(
            motion,
            (now, time),
            state,
            method="DOP853",
            rtol=1e-12,
            atol=1e-14,
            events=events or None,
        )
        now, state = found.t[-1], found.y[:, -1]
        if found.status == 1:
            passed = [i for i, hits in enumerate(found.t_events) if hits.size]
            stretch += 1 if events[passed[0]].direction > 0.0 else -1
    return state


def gap_force(clearance, stiffness=1000.0, damping=DAMPING):
    def force(x, v, stretch):
        return damping * v + stiffness * (0.0, x + clearance, x - clearance)[(1, 0, 2)[stretch]]

    return force


def shoot(force, load, omega, guess, walls=(), periods=1):
    """The state that repeats itself, by Newton's method with differences.

    Raises
    ------
    AssertionError
        If there is none near the guess.
    """
    state, time = np.array(guess), periods * 2.0 * np.pi / omega
    for _ in range(12):
        miss = flow(force, load, omega, state, time, walls) - state
        scale = np.abs(state) + 1e-3 * np.array([1.0, omega]) * np.max(np.abs(state))
        columns = []
        for i in range(2):
            moved = state.copy()
            moved[i] += 1e-6 * scale[i]
            columns.append(
                (flow(force, load, omega, moved, time, walls) - moved - miss)
                / (1e-6 * scale[i])
            )
        step = np.linalg.solve(np.array(columns).T, -miss)
        state = state + step
        if np.max(np.abs(step / scale)) < 1e-11:
            return state
    raise AssertionError("shooting did not converge")
