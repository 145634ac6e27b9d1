"""An effect that is asked for: where it may stand, what is looked for, where fits start."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import final

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.hypotheses.joints import Joint
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
        Coordinates to start from beside its own [SI].
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
    """Return the effects to look for in every joint: the wanted one, and those it contains.

    The wanted one begins from the numbers that were given, too.

    Raises
    ------
    DiagnosisError
        If the effect has no number of such a name.
    """
    return {
        joint: _begun(with_contained(campaign.known[joint], wanted.kind), wanted)
        for joint in joints_of(campaign, wanted)
    }


def _begun(laws: dict[str, Identification], wanted: Wanted) -> dict[str, Identification]:
    law = laws.get(wanted.kind)
    if law is None or not wanted.start:
        return laws
    first = law.starts[0]
    unknown = [name for name in wanted.start if name not in first]
    if unknown:
        raise DiagnosisError(
            f"{wanted.kind} has no number {unknown[0]!r} to start from; it has "
            f"{', '.join(first)}."
        )
    starts = ({**first, **wanted.start}, *law.starts)
    return {**laws, wanted.kind: replace(law, starts=starts)}


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
