"""Checks of a test: required and forbidden keys, and those unique among tests."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from shakerproc.testlog.excitation import BROADBAND
from shakerproc.testlog.log import reserved_names
from shakerproc.testlog.misfit import MisfitError
from shakerproc.testlog.one_test import Test
from shakerproc.testlog.schema import TestSection
from shakerproc.units import quoted

_NEEDED: Final[Mapping[str, Mapping[str, str]]] = {
    "sine sweep": {"start": "from: 5 Hz", "stop": "to: 500 Hz"},
    "stepped sine": {"start": "from: 5 Hz", "stop": "to: 500 Hz"},
    "random": {"start": "from: 5 Hz", "stop": "to: 1000 Hz"},
    "multisine": {
        "start": "from: 5 Hz",
        "stop": "to: 500 Hz",
        "multisine": "multisine: {period: 2 s, periods: 9}",
    },
    "sine": {"frequency": "frequency: 50 Hz"},
    "sine on random": {"start": "from: 10 Hz", "stop": "to: 500 Hz"},
}
"""Fields that a kind of excitation needs, and how they may be written."""

_OUT_OF_PLACE: Final[Mapping[str, tuple[str, ...]]] = {
    "sine sweep": ("frequency",),
    "stepped sine": ("frequency",),
    "random": ("frequency", "rate"),
    "multisine": ("frequency", "rate"),
    "sine on random": ("frequency", "rate"),
    "sine": ("start", "stop", "rate"),
    "shock": ("frequency", "rate"),
    "hammer": ("frequency", "rate"),
    "free decay": ("frequency", "rate"),
    "measured": ("level", "frequency", "rate"),
}
"""Fields that mean nothing for a kind of excitation."""

_PLANNED: Final[Mapping[str, str]] = {
    "random": "0.04 g^2/Hz",
    "sine sweep": "2 g",
    "stepped sine": "2 g",
    "sine": "2 g",
    "multisine": "0.5 g rms",
    "sine on random": "0.04 g^2/Hz",
}
"""Kinds of excitation of which a log says all that shakes, and how a level may be written."""

_LASTING: Final = ("random", "sine", "sine on random")
_SWEPT: Final = ("sine sweep", "stepped sine")

_KEY: Final = {"start": "from", "stop": "to"}


def check_keys(section: TestSection) -> None:
    """Pass a test whose keys fit its kind of excitation.

    Raises
    ------
    MisfitError
        If one is missing, means nothing, or contradicts another.
    """
    kind = section.excitation or ""
    for field, example in _NEEDED.get(kind, {}).items():
        if getattr(section, field) is None and section.profile is None:
            raise MisfitError(
                f'expected the key "{_KEY.get(field, field)}" for excitation: {kind}, '
                f"such as {example}"
            )
    for field in _OUT_OF_PLACE.get(kind, ()):
        if field in section.model_fields_set:
            key = _KEY.get(field, field)
            raise MisfitError(f"means nothing for excitation: {kind}; take it out", key)
    _check_planned(section, kind)
    _check_multisine(section, kind)
    if section.tones is not None and kind != "sine on random":
        raise MisfitError("means something for excitation: sine on random only", "tones")
    if (section.start is None) != (section.stop is None):
        given = "to" if section.start is None else "from"
        raise MisfitError('expected both "from" and "to", or neither', given)
    if section.start is None or section.stop is None:
        return
    if section.start == section.stop:
        raise MisfitError("expected two frequencies that differ", "to")
    if kind in BROADBAND and section.start > section.stop:
        raise MisfitError("expected from below to; only a sweep can go down", "to")


def _check_planned(section: TestSection, kind: str) -> None:
    """Pass a planned test that says all that is to shake it, and no other that says as much.

    Raises
    ------
    MisfitError
        If something is missing, or contradicts that it is still to be run.
    """
    if not section.planned:
        if section.duration is not None:
            raise MisfitError(
                "means something for planned: true only; a recording tells its own length, "
                "expect: {duration: 40 s} checks it",
                "duration",
            )
        return
    if section.recording is not None:
        raise MisfitError(
            "expected no recording of a planned test; take planned: true out once it was run",
            "recording",
        )
    if kind not in _PLANNED:
        raise MisfitError(
            f"expected excitation of a planned test: {', '.join(_PLANNED)}, got "
            f"{kind or 'none'}",
            *(("excitation",) if kind else ("planned",)),
        )
    if section.level is None and section.profile is None:
        raise MisfitError(
            'expected the key "level" or "profile" of a planned test, such as '
            f"level: {_PLANNED[kind]}"
        )
    if kind in _LASTING and section.duration is None:
        raise MisfitError(
            f'expected the key "duration" of a planned test with excitation: {kind}, such as '
            "duration: 60 s; the largest value depends on it"
        )
    if kind in _SWEPT and section.duration is None and section.rate is None:
        raise MisfitError('expected the key "rate" of a planned sweep, such as 2 oct/min')
    if kind not in _LASTING and section.duration is not None and section.rate is not None:
        raise MisfitError("means nothing beside rate; take one of them out", "duration")


def _check_multisine(section: TestSection, kind: str) -> None:
    """Pass a test that says how it repeats only where it does, without contradiction.

    Raises
    ------
    MisfitError
        If another kind repeats, or realisations lie on each other.
    """
    said = section.multisine
    if said is None:
        return
    if kind != "multisine":
        raise MisfitError("means something for excitation: multisine only", "multisine")
    if said.every is not None:
        if said.every < said.period * (said.periods or 1):
            raise MisfitError(
                "expected no less than the periods of a realisation take", "multisine", "every"
            )
        if said.periods is None:
            raise MisfitError("expected periods beside it", "multisine", "every")


class Sharing:
    """Ids, spellings and recordings of the tests read so far."""

    def __init__(self) -> None:
        self.ids: dict[str, tuple[Test, int]] = {}
        self.spellings: dict[tuple[str, str], tuple[str, int]] = {}
        self.reserved = reserved_names()
        self.spelt: set[tuple[str, str]] = set()
        self.recordings: dict[Path, list[tuple[Test, int]]] = {}

    def check(self, test: Test, line: int) -> None:
        """Pass a test that shares nothing it must not share.

        Raises
        ------
        MisfitError
            If its id, its recording or a spelling is in the way of another test.
        """
        owner, first = self.ids.setdefault(str(test.id).casefold(), (test, line))
        if owner is not test:
            raise MisfitError(
                f"expected an id of its own, got {quoted(str(test.id))} as on line {first}",
                "id",
            )
        for name in test.tags:
            if name in self.reserved:
                raise MisfitError(
                    "is the name of a column that every table has; choose another name",
                    "tags",
                    name,
                )
        for key in ("joint", "specimen", "orientation"):
            self._check_spelling(key, getattr(test, key), line)
        if test.recording is not None and not test.discarded:
            self._check_recording(test, self.recordings.setdefault(test.recording, []), line)

    @staticmethod
    def _check_recording(test: Test, others: list[tuple[Test, int]], line: int) -> None:
        """Pass a recording that no other test processes in the same way.

        Raises
        ------
        MisfitError
            If one does.
        """
        for other, first in others:
            if other.processing == test.processing:
                raise MisfitError(
                    f"is the recording of test {other.id} on line {first} as well, cropped the "
                    "same way; correct the path, or give each its crop",
                    "recording",
                )
        others.append((test, line))

    def _check_spelling(self, key: str, value: str, line: int) -> None:
        """Pass a name that is spelt as it was before.

        Raises
        ------
        MisfitError
            If it differs by case, spaces, hyphens or underscores only: tables would split.
        """
        if not value or (key, value) in self.spelt:
            return
        self.spelt.add((key, value))
        folded = "".join(c for c in value.casefold() if c not in " _-")
        known, first = self.spellings.setdefault((key, folded), (value, line))
        if known != value:
            raise MisfitError(
                f'got {quoted(value)}; did you mean "{known}", as on line {first}?', key
            )
