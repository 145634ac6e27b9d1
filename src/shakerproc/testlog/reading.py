"""The YAML log sheet, read into a TestLog: cross-checked, every message with its place."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Final, Literal, final

from shakerproc.data import Calibration, ChannelUse
from shakerproc.documents import Document, Key, read_document
from shakerproc.errors import LogError
from shakerproc.geometry import LEAST, Place, Wireframe, problem_of
from shakerproc.geometry.data_sets import UffError
from shakerproc.geometry.universal import read_wireframe
from shakerproc.testlog.excitation import LevelUnit, Profile, level_of, rate_of, tidy
from shakerproc.testlog.fields import Below, MisfitError, csv_cells, relative_path
from shakerproc.testlog.header import Header, Shaker, Specimen, limits_of
from shakerproc.testlog.log import Sharing, TestLog, check_keys
from shakerproc.testlog.merging import (
    merged_channels,
    merged_expectation,
    merged_processing,
    modal_of,
    sample_rate_of,
)
from shakerproc.testlog.one_test import Event, Expectation, FurtherRecording, Tag, Test
from shakerproc.testlog.processing import Processing
from shakerproc.testlog.processing_sections import multisine_of, tones_of
from shakerproc.testlog.profiles import fitting_profile, profile_of
from shakerproc.testlog.schema import (
    BesideSection,
    ChannelSection,
    GeometrySection,
    LogSection,
    TestSection,
    header_of,
)
from shakerproc.testlog.sheets import Table, calibrated, read_calibrations, specimens_of
from shakerproc.units import quoted, to_si

LARGEST: Final = 100_000_000
"""Largest file that is read; a mesh of a million nodes has that much [byte]."""

_UNIVERSAL: Final = (".uff", ".unv", ".uf58")
_HEADER: Final = re.compile(
    r"(?P<name>node|x|y|z)\s*(?:[\[(](?P<unit>.*)[\])])?", re.IGNORECASE
)
_WANTED: Final = '"node,x [mm],y [mm],z [mm]"'


def geometry_of(section: str | GeometrySection | None, folder: Path) -> Wireframe | None:
    """Return the geometry of a log, None where it has none.

    Raises
    ------
    MisfitError
        If a line or a surface has a node without coordinates.
    LogError
        If a file of it cannot be used.
    """
    if section is None:
        return None
    if isinstance(section, str):
        path = Below(folder).path(section)
        if path.suffix.lower() == ".csv":
            return Wireframe(_table(path))
        if path.suffix.lower() not in _UNIVERSAL:
            raise MisfitError(
                f"expected a file .uff, .unv or .csv, or nodes and lines, got {quoted(section)}"
            )
        return _universal(path)
    given = section.nodes
    nodes = _table(Below(folder).path(given)) if isinstance(given, str) else given
    for kind in LEAST:
        for number, one in enumerate(getattr(section, kind)):
            if problem := problem_of(nodes, kind, one):
                raise MisfitError(problem, kind, number)
    return Wireframe(nodes, section.lines, section.surfaces)


def _universal(path: Path) -> Wireframe:
    """Return the geometry of a universal file.

    Raises
    ------
    LogError
        If it cannot be used.
    """
    try:
        return read_wireframe(_content(path))
    except UffError as error:
        raise LogError(f"{path}: {error}") from error


def _content(path: Path) -> bytes:
    """Return the content of a file.

    Raises
    ------
    LogError
        If there is none, or it is too large.
    """
    if not path.is_file():
        raise LogError(f"{path}: no such file; put the geometry there")
    if path.stat().st_size > LARGEST:
        raise LogError(f"{path}: expected a geometry, got more than {LARGEST / 1e6:g} MB")
    return path.read_bytes()


def _table(path: Path) -> dict[int, Place]:
    """Return the nodes of a table [m].

    Raises
    ------
    LogError
        If it is none; the line is named.
    """
    filled = [row for row in csv_cells(_content(path), path, comments=True) if any(row[1])]
    if not filled:
        raise LogError(f"{path}: expected a header {_WANTED}, got an empty file")
    columns, unit = _columns(path, *filled[0])
    nodes: dict[int, Place] = {}
    for line, cells in filled[1:]:
        number, *texts = (cells[at] if at < len(cells) else "" for at in columns)
        place = f"{path}:{line}"
        if not re.fullmatch(r"[1-9]\d{0,8}", number):
            raise LogError(f"{place}: expected the number of a node, got {quoted(number)}")
        if "" in texts:
            raise LogError(f"{place}: node {number} has no {'xyz'[texts.index('')]}")
        if int(number) in nodes:
            raise LogError(f"{place}: node {number} stands twice")
        try:
            x, y, z = (to_si(f"{text.replace(',', '.')} {unit}", "m") for text in texts)
        except ValueError as error:
            raise LogError(f"{place}: node {number}: {error}") from error
        nodes[int(number)] = (x, y, z)
    return nodes


def _columns(path: Path, line: int, header: Sequence[str]) -> tuple[tuple[int, ...], str]:
    """Return where node, x, y and z stand, and the unit of the coordinates.

    Raises
    ------
    LogError
        If a column is missing, or the coordinates have no unit or several.
    """
    columns: dict[str, tuple[int, str]] = {}
    for at, cell in enumerate(header):
        if match := _HEADER.fullmatch(cell):
            columns.setdefault(match["name"].lower(), (at, (match["unit"] or "").strip()))
    got = ", ".join(header)
    if columns.keys() != {"node", "x", "y", "z"}:
        raise LogError(f"{path}:{line}: expected a header {_WANTED}, got {quoted(got)}")
    units = dict.fromkeys(columns[name][1] for name in "xyz")
    if len(units) > 1 or "" in units:
        text = " and ".join(unit or "none" for unit in units)
        raise LogError(
            f"{path}:{line}: expected one unit for x, y and z, as in {_WANTED}, got {text}"
        )
    return tuple(columns[name][0] for name in ("node", "x", "y", "z")), next(iter(units))


def seated(
    uses: Sequence[ChannelUse],
    sections: Mapping[Key, ChannelSection],
    wireframe: Wireframe | None,
) -> tuple[ChannelUse, ...]:
    """Return channels with the positions of their nodes, directions turned as these are.

    Raises
    ------
    MisfitError
        If a node is not of the geometry, or a position stands beside it.
    """
    return tuple(_at_node(use, sections[use.key].node, wireframe) for use in uses)


def _at_node(use: ChannelUse, node: int | None, wireframe: Wireframe | None) -> ChannelUse:
    """Return a channel at its node.

    Raises
    ------
    MisfitError
        If it cannot be.
    """
    if node is None:
        return use
    if use.position is not None:
        raise MisfitError("expected node or position, not both", use.key, "node")
    if wireframe is None:
        raise MisfitError(
            "expected geometry: beside channels:, which says where the nodes are",
            use.key,
            "node",
        )
    if problem := problem_of(wireframe.nodes, "node", (node,)):
        raise MisfitError(problem, use.key, "node")
    along = use.direction and wireframe.turned(node, use.direction)
    return replace(use, position=wireframe.nodes[node], direction=along)


def read_testlog(path: Path, *, strict: bool = False) -> TestLog:
    """Return the test log of a YAML log sheet.

    Parameters
    ----------
    path : Path
        The YAML file; configs/all_keys.yaml explains every key.
    strict : bool
        Refuse the log where a recording is missing; otherwise that is an error of its test
        alone, which `Test.require_recording` raises.

    Raises
    ------
    DocumentError
        If the log cannot be used, with file, line and column, what was expected and found.
    """
    document = read_document(path, LogSection)
    log = _Reader(document).log()
    if strict:
        _require_recordings(log)
    return log


def _require_recordings(log: TestLog) -> None:
    """Pass a log whose recordings are all there.

    Raises
    ------
    DocumentError
        If one is missing.
    """
    missing = [
        i
        for i, test in enumerate(log.tests)
        if not test.discarded and not (test.recording and test.recording.is_file())
    ]
    if missing:
        first = log.tests[missing[0]]
        problem = f"no recording {first.recording}" if first.recording else "no recording"
        more = f" ({len(missing) - 1} more are missing)" if len(missing) > 1 else ""
        raise log.document.error(("tests", missing[0], "recording"), problem + more)


CONDITION: Final = "condition"
"""Role of a channel that scales effects of a model."""


class _Reader:
    """Builds the tests of one log; `Sharing` refuses ids and recordings that stand twice."""

    def __init__(self, document: Document[LogSection]) -> None:
        section = document.value
        self.document = document
        self.section = section
        self.specimens: Table = specimens_of(document)
        self.recordings = _recordings(document)
        self.sharing = Sharing()
        self.calibrations = self._calibrations()
        with _At(document, "geometry"):
            self.geometry = geometry_of(section.geometry, document.path.parent)
        with _At(document, "channels"):
            self.channels = self._channels(section.channels, {})
        with _At(document, "processing"):
            merged = merged_processing(Processing(), section.processing, self.channels)
            said = frozenset(section.processing.model_fields_set)
            self.processing = replace(merged, inherited=said)
        with _At(document, "modal"):
            self.modal = modal_of(section.modal)
        self.expect = merged_expectation(Expectation(), section.expect)
        self.profiles = {name: self._profile(name) for name in section.profiles}
        self.header = self._header()
        listed = () if self.header is None else self.header.instruments
        self.instruments = tuple(one for one in listed if one.valid_until)

    def log(self) -> TestLog:
        tests = [self._test(i, test) for i, test in enumerate(self.section.tests)]
        with _At(self.document, "limits"):
            limits = limits_of(self.section.limits, self.channels)
        return TestLog(
            path=self.document.path,
            title=self.section.title or self.document.path.stem,
            folder=self.recordings.folder,
            tests=tuple(test for test in tests if test.discarded or not test.planned),
            specimens=tuple(self.specimens.values()),
            document=self.document,
            shaker=Shaker(**dict(self.section.shaker)),
            modal=self.modal,
            header=self.header,
            planned=tuple(test for test in tests if test.planned and not test.discarded),
            limits=limits,
        )

    def _header(self) -> Header | None:
        if self.section.report is None:
            return None
        with _At(self.document, "report"):
            return header_of(self.section.report, Below(self.document.path.parent).path)

    def _test(self, i: int, section: TestSection) -> Test:
        line = self.document.line(("tests", i))
        if not section.discarded:
            with _At(self.document, "tests", i):
                check_keys(section)
        specimen, actual = self._specimen(i, section), section.actual_clearance
        level, level_unit = self._level(i, section)
        per_octave, linear = self._rate(i, section)
        channels, measured, processing = self._merged(i, section)
        with _At(self.document, "tests", i):
            profile = fitting_profile(self.profiles, section, level_unit)
            low, high = _ends(section, profile)
            unit = level_unit if profile is None else profile.unit
            tones = tones_of(section.tones or (), (low, high), unit)
        test = Test(
            id=section.id,
            recording=self._recording(i, section),
            joint=section.joint or "",
            specimen=section.specimen or "",
            clearance=specimen.nominal if section.clearance is None else section.clearance,
            actual_clearance=specimen.actual if actual is None else actual,
            actual_axial_clearance=specimen.actual_axial if actual is None else None,
            orientation=section.orientation or "",
            excitation=section.excitation,
            level=level,
            level_unit=level_unit,
            level_text=tidy(section.level) if level is not None else "",
            from_hz=low,
            to_hz=high,
            rate_oct_per_min=per_octave,
            rate_hz_per_s=linear,
            frequency_hz=section.frequency,
            notch_hz=section.notch,
            discarded=section.discarded,
            comment=section.comment,
            hold_out=section.hold_out,
            tags={name: _tag(value) for name, value in section.tags.items()},
            channels=channels,
            processing=processing,
            expect=merged_expectation(self.expect, section.expect),
            source=f"{self.document.path}:{line}",
            folder=self.recordings.folder,
            profile=profile,
            continued=self._continued(i, section),
            beside=tuple(
                self._further_recording(i, j, one) for j, one in enumerate(section.beside)
            ),
            multisine=multisine_of(section.multisine),
            tones=tones,
            events=tuple(Event(event.at, event.note) for event in section.events),
            instruments=self.instruments,
            planned=section.planned,
            duration=section.duration,
            geometry=self.geometry,
            conditions=section.conditions,
            measured_conditions=measured,
        )
        with _At(self.document, "tests", i):
            self.sharing.check(test, line)
        return test

    def _channels(
        self, log: Mapping[Key, ChannelSection], test: Mapping[Key, ChannelSection]
    ) -> tuple[ChannelUse, ...]:
        """Return the uses of the channels, calibrated and at their nodes."""
        uses = calibrated(merged_channels(log, test), self.calibrations)
        return seated(uses, dict(log) | dict(test), self.geometry)

    def _calibrations(self) -> dict[str, Calibration]:
        if self.section.calibration is None:
            return {}
        with _At(self.document, "calibration"):
            path = Below(self.document.path.parent).path(self.section.calibration)
        return read_calibrations(path)

    def _profile(self, name: str) -> Profile:
        with _At(self.document, "profiles", name):
            return profile_of(
                name,
                self.section.profiles[name],
                Below(self.document.path.parent).path,
                self.processing.tolerance,
            )

    def _level(
        self, i: int, section: TestSection
    ) -> tuple[float, LevelUnit] | tuple[None, None]:
        if "level" not in section.model_fields_set:
            return None, None
        with _At(self.document, "tests", i, "level"):
            return level_of(section.level, section.excitation)

    def _rate(self, i: int, section: TestSection) -> tuple[float | None, float | None]:
        if "rate" not in section.model_fields_set:
            return None, None
        with _At(self.document, "tests", i, "rate"):
            return rate_of(section.rate)

    def _recording(self, i: int, section: TestSection) -> Path | None:
        if section.recording is None:
            return None
        with _At(self.document, "tests", i, "recording"):
            return self.recordings.path(section.recording)

    def _continued(self, i: int, section: TestSection) -> tuple[str, ...]:
        """Return the files that follow the recording of a test.

        Raises
        ------
        MisfitError
            If there is none, or one stands twice.
        """
        for j, name in enumerate(section.continued):
            with _At(self.document, "tests", i, "continued", j):
                self.recordings.path(name)
                if section.recording is None:
                    raise MisfitError("expected a recording that it continues")
                if name in {section.recording, *section.continued[:j]}:
                    raise MisfitError("expected each file once")
        return tuple(map(relative_path, section.continued))

    def _further_recording(self, i: int, j: int, section: BesideSection) -> FurtherRecording:
        """Return the further parts of a test, beside its recording.

        Raises
        ------
        MisfitError
            If it does not say where its channels are, or what its clock is found by.
        """
        name, common = section.recording, section.common
        with _At(self.document, "tests", i, "beside", j):
            if name is not None:
                with _At(self.document, "tests", i, "beside", j, "recording"):
                    self.recordings.path(name)
            if name is not None and common is None:
                raise MisfitError(
                    "expected common: {channel of the recording: channel of this one}, which "
                    "both recorders measured and which gives the offset and drift of the clock"
                )
            if name is None and section.group is None:
                raise MisfitError("expected recording or group: where the channels are")
            with _At(self.document, "tests", i, "beside", j, "channels"):
                channels = self._channels({}, section.channels)
            return FurtherRecording(
                None if name is None else relative_path(name),
                channels,
                section.group,
                *sample_rate_of(section.sample_rate),
                None if common is None else next(iter(common.items())),
            )

    def _specimen(self, i: int, section: TestSection) -> Specimen:
        """Return the measured specimen of a test, an unmeasured one where there is none.

        Raises
        ------
        DocumentError
            If the test's nominal clearance is another than the specimen's.
        """
        joint, name = section.joint or "", section.specimen or ""
        specimen = self.specimens.get((joint, name), Specimen(joint, name))
        given, nominal = section.clearance, specimen.nominal
        if given is not None and nominal is not None and abs(given - nominal) > 1e-9:
            raise self.document.error(
                ("tests", i, "clearance"),
                f"expected {nominal * 1e3:g} mm, the nominal clearance of {joint} {name} under "
                f"specimens, got {given * 1e3:g} mm",
            )
        return specimen

    def _merged(
        self, i: int, section: TestSection
    ) -> tuple[tuple[ChannelUse, ...], tuple[ChannelUse, ...], Processing]:
        """Return the channels, those that measure conditions, and the processing of a test."""
        channels, processing = self.channels, self.processing
        if section.channels:
            with _At(self.document, "tests", i, "channels"):
                channels = self._channels(self.section.channels, section.channels)
        if section.channels or "processing" in section.model_fields_set:
            with _At(self.document, "tests", i, "processing"):
                processing = merged_processing(processing, section.processing, channels)
        measured = tuple(use for use in channels if use.role == CONDITION)
        analysed = tuple(
            replace(use, role="ignore") if use.role == CONDITION else use for use in channels
        )
        return analysed, measured, processing


def _recordings(document: Document[LogSection]) -> Below:
    """Return the folder that all recordings lie in."""
    with _At(document, "recordings"):
        return Below(Below(document.path.parent).path(document.value.recordings))


def _ends(
    section: TestSection, profile: Profile | None
) -> tuple[float, float] | tuple[float | None, float | None]:
    """Return from where to where a test excites; a profile says it where the test does not."""
    if profile is None or section.start is not None:
        return section.start, section.stop
    return profile.frequency_hz[0], profile.frequency_hz[-1]


def _tag(value: Tag) -> Tag:
    """Return a tag as text or number: true and false are text."""
    return str(value).lower() if isinstance(value, bool) else value


@final
class _At:
    """Adds the place in the file to errors raised inside it."""

    __slots__ = ("document", "place")

    def __init__(self, document: Document[LogSection], *place: Key) -> None:
        self.document, self.place = document, place

    def __enter__(self) -> None:
        """Do nothing."""

    def __exit__(
        self, kind: object, error: BaseException | None, trace: TracebackType | None
    ) -> Literal[False]:
        if isinstance(error, MisfitError):
            raise self.document.error((*self.place, *error.place), str(error)) from error
        if isinstance(error, ValueError):
            raise self.document.error(self.place, str(error)) from error
        return False
