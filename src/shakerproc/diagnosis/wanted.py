"""An effect that is asked for: where it may stand, what is looked for, where fits start."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import final

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.hypotheses.joints import Joint
from shakerproc.diagnosis.screening import Start
from shakerproc.errors import DiagnosisError
from shakerproc.models import Scale
from shakerproc.models.effects import Table
from shakerproc.models.identification import Identification, Values


@final
@dataclass(frozen=True, slots=True)
class Wanted:
    """Effect that is to be added.

    Attributes
    ----------
    kind : str
        Key of the effect.
    between : (str, str), optional
        The joint; by default the one where it fits best.
    start : mapping of str to float or str
        Coordinates to start from beside those of the screening [SI].
    scaled_by : Scale, optional
        Condition of the tests that its force is proportional to.
    """

    kind: str
    between: Joint | None = None
    start: Values = field(default_factory=lambda: MappingProxyType({}))
    scaled_by: Scale | None = None

    @property
    def is_free_law(self) -> bool:
        """Whether it is the force without a name, which is found by regression alone."""
        return self.kind == Table.kind


def joints_of(campaign: Campaign, wanted: Wanted) -> list[Joint]:
    """Return the joints in which the effect is fitted."""
    place = wanted.between
    return [j for j in campaign.known if place is None or set(j) == set(place)]


def sought(campaign: Campaign, wanted: Wanted) -> dict[Joint, dict[str, Identification]]:
    """Return the effects to look for in every joint: the wanted one, and those it contains."""
    joints = joints_of(campaign, wanted)
    return {
        joint: with_contained(known, wanted.kind) if joint in joints else {}
        for joint, known in campaign.known.items()
    }


def with_contained(known: Mapping[str, Identification], kind: str) -> dict[str, Identification]:
    """Return the identification of an effect in a joint, and of those that it contains."""
    found: dict[str, Identification] = {}
    waiting = [kind]
    while waiting:
        name = waiting.pop()
        if name in known and name not in found:
            found[name] = known[name]
            waiting += [one.kind for one in known[name].contains]
    return found


def with_own(starts: Sequence[Start], wanted: Wanted) -> list[Start]:
    """Return starts of the screening, before them the best with the numbers that were given.

    Raises
    ------
    DiagnosisError
        If the effect has no number of such a name.
    """
    kept = [replace(start, kept=True) for start in starts]
    if not wanted.start:
        return kept
    own: dict[Joint, Start] = {}
    for start in kept:
        if start.kind == wanted.kind:
            own.setdefault(start.between, start)
    for start in own.values():
        unknown = [name for name in wanted.start if name not in start.values]
        if unknown:
            raise DiagnosisError(
                f"{wanted.kind} has no number {unknown[0]!r} to start from; it has "
                f"{', '.join(start.values)}."
            )
    given = [replace(start, values={**start.values, **wanted.start}) for start in own.values()]
    return [*given, *kept]
