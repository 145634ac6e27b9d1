"""The log sheet of a campaign, in SI: its tests, specimens and shaker."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import LogError
from shakerproc.testlog.excitation import LevelUnit
from shakerproc.testlog.header import Header, Limit, Shaker, Specimen
from shakerproc.testlog.one_test import Fact, Test
from shakerproc.testlog.processing import Modal
from shakerproc.units import near_miss

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
        found = tuple(test for test in self.active if test.recording is not None)
        if not found:
            raise LogError(
                f"{self.path.name}: no test has a recording that may be used. Give a test its "
                "recording, or take back discarded."
            )
        return found

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
