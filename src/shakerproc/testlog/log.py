"""The log sheet of a campaign, in SI: its tests, specimens and shaker, and checks of a test."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import LogError
from shakerproc.testlog.excitation import BROADBAND, LevelUnit
from shakerproc.testlog.fields import MisfitError
from shakerproc.testlog.header import Header, Limit, Shaker, Specimen
from shakerproc.testlog.one_test import Fact, Test
from shakerproc.testlog.processing import Modal
from shakerproc.testlog.schema import TestSection
from shakerproc.units import near_miss, quoted

if TYPE_CHECKING:
    from shakerproc.documents import Document


_LEVELS: Final[tuple[tuple[LevelUnit, str, float], ...]] = (
    ("m/s^2", "level_g", STANDARD_GRAVITY),
    ("(m/s^2)^2/Hz", "level_g2_per_hz", STANDARD_GRAVITY**2),
    ("m/s^2 rms", "level_g_rms", STANDARD_GRAVITY),
    ("N", "level_n", 1.0),
    ("N^2/Hz", "level_n2_per_hz", 1.0),
    ("N rms", "level_n_rms", 1.0),
    ("rad/s^2", "level_rad_per_s2", 1.0),
    ("(rad/s^2)^2/Hz", "level_rad2_per_s4_per_hz", 1.0),
    ("rad/s^2 rms", "level_rad_per_s2_rms", 1.0),
    ("N m", "level_nm", 1.0),
    ("(N m)^2/Hz", "level_nm2_per_hz", 1.0),
    ("N m rms", "level_nm_rms", 1.0),
)
_OTHERS: Final = ("test", "id", "recording", "channel", "status", "sha256", "error")
"""Further columns that tables have, from elsewhere."""


def facts_of(test: Test) -> dict[str, Fact]:
    """Return the columns of a test: units in the names, tags last, None where nothing is said.

    Levels stand in the column of their kind: ``level_g`` (amplitude), ``level_g2_per_hz``,
    ``level_g_rms``, ``level_n``, ``level_rad_per_s2``, ``level_nm`` and so on; ``level`` is as
    written.
    """
    return {
        "joint": test.joint,
        "specimen": test.specimen,
        "clearance_m": test.clearance,
        "actual_clearance_m": test.actual_clearance,
        "actual_axial_clearance_m": test.actual_axial_clearance,
        "orientation": test.orientation,
        "excitation": test.excitation or "",
        "level": test.level_text,
        **_level(test),
        "from_hz": test.from_hz,
        "to_hz": test.to_hz,
        "rate_oct_per_min": test.rate_oct_per_min,
        "excitation_hz": test.frequency_hz,
        "notch_hz": test.notch_hz,
        "hold_out": test.hold_out,
        "discarded": test.discarded,
        "comment": test.comment,
        **test.tags,
    }


def reserved_names() -> frozenset[str]:
    """Return the names that no tag may take: those of the columns that every table has."""
    plain = facts_of(Test(id=0))
    levels = [column for _, column, _ in _LEVELS]
    return frozenset([*plain, *levels, *_OTHERS])


def _level(test: Test) -> dict[str, Fact]:
    columns: dict[str, Fact] = {}
    for unit, column, scale in _LEVELS:
        if unit == test.level_unit and test.level is not None:
            # Twelve digits: 15 g written is 15 g shown, not 15.000000000000002.
            columns[column] = float(f"{test.level / scale:.12g}")
    return columns


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class TestLog:
    """The log sheet of a campaign.

    Attributes
    ----------
    path : Path
        The file.
    title : str
        As the log has it; by default the name of the file.
    folder : Path
        Below which every recording lies.
    tests : tuple of Test
        In the order of the log, discarded ones included, planned ones not.
    specimens : tuple of Specimen
        Measured dimensions, where the log gives them.
    document : Document
        For messages with line and column.
    shaker : Shaker
        What the shaker can do, where the log says it.
    modal : Modal
        How modes are looked for.
    header : Header, optional
        What stands at the top of the report, where the log says it.
    planned : tuple of Test
        Those that have not been run yet, in the order of the log.
    limits : tuple of Limit
        What planned tests must not exceed.
    """

    __test__ = False  # not a test case, whatever pytest thinks of the name

    path: Path
    title: str
    folder: Path
    tests: tuple[Test, ...]
    specimens: tuple[Specimen, ...]
    document: "Document[Any]"
    shaker: Shaker = field(default_factory=Shaker)
    modal: Modal = field(default_factory=Modal)
    header: Header | None = None
    planned: tuple[Test, ...] = ()
    limits: tuple[Limit, ...] = ()

    def __repr__(self) -> str:
        tests = f"{len(self.tests)} test{'s' * (len(self.tests) != 1)}"
        left_out = len(self.tests) - len(self.active)
        discarded = f", {left_out} of them discarded" if left_out else ""
        planned = f", {len(self.planned)} planned" if self.planned else ""
        return f"Test log {self.path}: {self.title}; {tests}{discarded}{planned}"

    @property
    def active(self) -> tuple[Test, ...]:
        """Tests that are neither discarded nor planned."""
        return tuple(test for test in self.tests if not test.discarded)

    @property
    def left_out(self) -> tuple[str, ...]:
        """The sentence that planned tests take no part; none where there is no such test."""
        if not self.planned:
            return ()
        ids = ", ".join(str(test.id) for test in self.planned)
        several = len(self.planned) > 1
        return (
            f"{'tests' if several else 'test'} {ids} {'are' if several else 'is'} planned and "
            f"not run yet: left out here; `shakerproc forecast` says what "
            f"{'they' if several else 'it'} will do",
        )

    def recorded(self) -> tuple[Test, ...]:
        """Return the tests that have a recording and are not discarded.

        Raises
        ------
        LogError
            If there is none.
        """
        tests = tuple(test for test in self.active if test.recording is not None)
        if not tests:
            raise LogError(
                f"{self.path.name}: no test has a recording that may be used. Give a test its "
                "recording, or take back discarded."
            )
        return tests

    def find(self, identity: str | int) -> Test:
        """Return the test of this id; ``1`` and ``"1"`` are the same.

        Raises
        ------
        LogError
            If there is none.
        """
        by_id = {str(test.id): test for test in (*self.tests, *self.planned)}
        if str(identity) in by_id:
            return by_id[str(identity)]
        meant = near_miss(str(identity), list(by_id))
        question = f'; did you mean "{meant}"?' if meant else ""
        ids = list(by_id)
        known = ", ".join(ids if len(ids) <= 12 else [*ids[:6], "...", *ids[-3:]])
        raise LogError(f'{self.path}: no test "{identity}"{question}; the log has {known}')

    def error(self, test: Test, message: str, *key: str | int) -> LogError:
        """Return the error to raise about a test, at one of its keys where one is given."""
        every = [str(section.id) for section in self.document.value.tests]
        if str(test.id) not in every:  # made from one that is there
            return LogError(f"{test.source}: test {test.id}: {message}")
        place = self.document.error(("tests", every.index(str(test.id)), *key), message)
        return LogError(str(place))


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
    for name, example in _NEEDED.get(kind, {}).items():
        if getattr(section, name) is None and section.profile is None:
            raise MisfitError(
                f'expected the key "{_KEY.get(name, name)}" for excitation: {kind}, '
                f"such as {example}"
            )
    for name in _OUT_OF_PLACE.get(kind, ()):
        if name in section.model_fields_set:
            key = _KEY.get(name, name)
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
