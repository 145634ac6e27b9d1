"""The screening: every effect's force along the measured motion, tried as the missing one."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.hypotheses.joints import wells_of
from shakerproc.diagnosis.screening.laws import Law, laws_of, one_of_each_shape
from shakerproc.diagnosis.screening.refining import refined
from shakerproc.diagnosis.screening.regression import Gains
from shakerproc.diagnosis.screening.shared import Screening, linear_parts, screening_of
from shakerproc.diagnosis.screening.start import Start
from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.models import Model
from shakerproc.models.identification import Identification, number

_BATCH: Final = 16
"""Laws whose columns are held in memory at once: 50 MB for a chain of three masses [-]."""

_FAR: Final = 10.0
"""How many times more than the best an effect may leave unexplained and still be tried. Of 66
tuning draws the true one left at most 2.8 times as much before its coordinates were refined
[-]."""

_HOPELESS: Final = 100.0
"""How many times more than the best an effect may leave after two rounds of refinement and be
refined further [-]."""

_EXPLAINED: Final = 3.0
"""Mean square left, in units of the noise, at which an effect explains nearly all [-]."""

_TOLD: Final = 2.0
"""Standard errors by which an effect must predict beyond a model that explains the tests:
95 % of a normal law [-]."""

_REFINED: Final = 8
"""Effects whose best start is refined: what the time allows [-]."""


def starts_of(screening: Screening, laws: Sequence[Law]) -> list[tuple[Law, Start]]:
    """Return the start of every law, its force scaled."""
    found = []
    for own in alike(laws):
        for i in range(0, len(own), _BATCH):
            some = own[i : i + _BATCH]
            gains = screening.gains(some)
            found += [(law, _start(screening, law, gains, k)) for k, law in enumerate(some)]
    return found


def alike(laws: Sequence[Law]) -> list[list[Law]]:
    """Return laws by the motion that they see."""
    found: dict[tuple[Joint, bool], list[Law]] = {}
    for law in laws:
        found.setdefault((law.between, law.effect.absolute), []).append(law)
    return list(found.values())


def _start(screening: Screening, law: Law, gains: Gains, i: int) -> Start:
    """Return the start that the gains of a law mean."""
    amplitude, cost = float(gains.amplitude[i]), screening.regression.cost
    stiffness, damping = screening.relative_changes(gains.common[i])
    return Start(
        kind=law.kind,
        between=law.between,
        values=law.scaled(amplitude) if amplitude != 0.0 else law.values,
        stiffness=stiffness,
        damping=damping,
        explained=float(gains.explained[i]),
        predicted=float(gains.predicted[i]),
        t=float(gains.t[i]),
        left=float(1.0 - gains.explained[i]) * cost / screening.equations.n_numbers,
        told=not law.constant,
    )


def screen(
    model: Model,
    tests: Sequence[Test],
    joints: Sequence[Joint],
    identifications: Mapping[Joint, Mapping[str, Identification]],
    *,
    explained: bool = False,
) -> tuple[Start, ...]:
    """Return starts of every effect in every joint, best first.

    Parameters
    ----------
    model : Model
        The linear model.
    tests : sequence of Test
        What may be fitted to.
    joints : sequence of (str, str)
        Where an effect may be missing.
    identifications : mapping of joint to mapping of str to Identification
        Every effect that may be missing there.
    explained : bool
        Whether the model leaves no more than noise, of whole tests where these begin at rest:
        then an effect has to predict something beyond it.
    """
    screening = screening_of(model, tests, joints)
    laws = [law for joint in joints for law in laws_of(model, joint, identifications[joint])]
    return ranked(screening, laws, explained=explained)


def ranked(
    screening: Screening, laws: Sequence[Law], *, explained: bool = False
) -> tuple[Start, ...]:
    """Return the starts of laws in the order in which they are worth a fit.

    The best are refined. Of dry friction little is seen where it sticks: it may explain what
    nothing else does, and its force may be several times what is seen.
    """
    rough = starts_of(screening, one_of_each_shape(laws))
    rough.sort(key=lambda one: -one[1].predicted)
    found = [*_finer(screening, rough), *rough]
    most = max((start.predicted for _, start in found), default=0.0)

    def promise(one: tuple[Law, Start]) -> float:
        return one[1].predicted + (1.0 - most if one[0].slides else 0.0)

    found = _marked(found, rough, explained=explained)
    found.sort(key=lambda one: -promise(one))
    every = [start for law, one in found for start in _of_every_size(law, one)]
    first = {(law.kind, law.between): (law, start) for law, start in reversed(found)}
    return (*every, *(own for one in first.values() for own in with_wells(screening, *one)))


def _finer(screening: Screening, rough: Sequence[tuple[Law, Start]]) -> list[tuple[Law, Start]]:
    """Return refined starts of the effects that explain most."""
    first: dict[tuple[object, ...], Law] = {}
    for law, start in rough:
        first.setdefault((start.kind, start.between, start.words), law)
    finer: list[tuple[Law, Start]] = []
    for law in list(first.values())[:_REFINED]:
        least = min((start.left for _, start in finer), default=np.inf)
        hopeless = _HOPELESS * least * screening.equations.n_numbers
        there, finest = refined(screening, law, hopeless)
        finer += starts_of(there, [finest])
    return finer


def _marked(
    found: Sequence[tuple[Law, Start]], rough: Sequence[tuple[Law, Start]], *, explained: bool
) -> list[tuple[Law, Start]]:
    """Return all starts, those of effects that leave far more than the best marked.

    Before refinement that is told of laws that do not stick; once another explains nearly all,
    of every law. Where the model explains the tests without any, those are marked
    that predict nothing beyond it. Of a constant force it is never told.
    """
    most = max((start.predicted for _, start in rough), default=0.0)
    least = min((start.left for _, start in found), default=np.inf)
    known: dict[tuple[str, Joint], Start] = {}
    surest: dict[tuple[str, Joint], float] = {}
    for _, start in sorted(found, key=lambda one: one[1].left):
        name = start.kind, start.between
        known.setdefault(name, start)
        surest[name] = max(start.t, surest.get(name, -np.inf))
    marked = []
    for law, start in found:
        name = start.kind, start.between
        best = known[name]
        nothing = explained and surest[name] < _TOLD
        far = not law.sticks and 1.0 - best.predicted > _FAR * (1.0 - most)
        refuted = least < _EXPLAINED and best.left > _HOPELESS * least
        kept = not start.told or not (far or refuted or nothing)
        marked.append((law, replace(start, kept=kept)))
    return marked


def _of_every_size(law: Law, start: Start) -> tuple[Start, ...]:
    """Return a start, and for dry friction the same with every force that it may have.

    Where a joint sticks, a regression sees a force that is many times too small.
    """
    if not law.slides:
        return (start,)
    name = law.identification.scaled[0]
    sizes = sorted({number(values, name) for values in law.identification.starts})
    at = replace(law, values=start.values)
    now = number(start.values, name)
    return (start, *(replace(start, values=at.scaled(size / now)) for size in sizes))


def with_wells(screening: Screening, law: Law, start: Start) -> tuple[Start, ...]:
    """Return starts of a law in a joint whose stiffness in the file is that of a well.

    A regression sees nothing of it (see `wells_of`). Only of laws of which nothing but the
    size is free.

    Parameters
    ----------
    screening : Screening
        The linear model and its motion.
    law, start : Law, Start
        The law, and what a regression says of it.
    """
    identification = law.identification
    if tuple(identification.scaled) != tuple(identification.free):
        return ()
    nearby = linear_parts(screening.model, law.between)[0]
    motion = screening.motions.across(law.between)
    largest = max(float(np.max(np.abs(one.displacement))) for one in motion)
    i = screening.joints.index(law.between)
    found = []
    for size, stiffness in wells_of(law.effect, nearby, largest):
        change = np.zeros(len(screening.joints))
        change[i] = stiffness / nearby - 1.0
        found.append(
            replace(
                start,
                values=law.scaled(size),
                stiffness=tuple(map(float, change)),
                damping=(0.0,) * change.size,
                kept=True,
            )
        )
    return tuple(found)
