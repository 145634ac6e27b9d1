"""Control and responses against the breakpoint profile of a test: a verdict by line."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.runs import flags, levels
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.levels import BEYOND_ALARM, rounded_within
from shakerproc.runs.panels import Analysis, Cell, Look, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.runs.tables import spelled
from shakerproc.spectra import CrossSpectra
from shakerproc.spectra.profiles import profile_at, profile_rms, surely_beyond
from shakerproc.testlog import Profile
from shakerproc.testlog.excitation import FORCES

LINES: Final[Mapping[str, tuple[Look, int]]] = {
    "alarm high": ("alarm", 1),
    "alarm low": ("alarm", -1),
    "abort high": ("abort", 1),
    "abort low": ("abort", -1),
}
"""The lines of a profile, and to which side of the demand each lies."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class JudgedControl:
    """Curve that is compared with a profile.

    Attributes
    ----------
    frequency : (n_points,) array
        Where [Hz].
    control : (n_points,) array
        Mean density, or amplitude, of the controls [unit of the profile].
    responses : mapping
        The same of each response by name.
    spectra : CrossSpectra, optional
        Of which a density is, so that chance is known; None of an amplitude.
    """

    frequency: FloatArray
    control: FloatArray
    responses: Mapping[str, FloatArray]
    spectra: CrossSpectra | None


@final
class ProfileJudgement(AbstractAnalysis):
    """Demand, alarm and abort lines, and whether the control kept them."""

    kind: ClassVar[str] = "profile"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return how the control keeps the profile of its test, if it has one."""
        del recording  # all of it stands in the result
        profile = result.test.profile
        if profile is None:
            return None
        rows = levels.watched_in(result.channels, profile.signal_unit)
        if not rows:
            role = "force" if profile.signal_unit in FORCES else "control"
            text = f"The profile {profile.name} is not judged: no channel has the role {role}."
            return Analysis(self.kind, "Profile", {}, (), (), (), (text,))
        judged = _judged(result, profile, rows)
        if not judged.frequency.size:
            text = (
                f"The profile {profile.name} is not judged: nothing was measured in its band."
            )
            return Analysis(self.kind, "Profile", {}, (), (), (), (text,))
        lines = lines_of(profile, judged.frequency)
        demand = profile_at(judged.frequency, *_points(profile))
        rms = _rms(result, profile, rows)
        summary = tuple(_verdict(name, lines[name], judged, profile) | rms for name in LINES)
        broken = [row for row in summary if not row["kept"]]
        return Analysis(
            kind=self.kind,
            title=f"Profile {profile.name}",
            columns=_columns(judged, demand, lines, profile),
            summary=summary,
            panels=(_panel(judged, profile, result),),
            sentences=(
                _verdict_text(summary, profile),
                *_rms_text(rms, _rms_band(result, profile)),
            ),
            problems=tuple(_broken(row, profile) for row in broken),
        )


def _points(profile: Profile) -> tuple[FloatArray, FloatArray]:
    return np.array(profile.frequency_hz), np.array(profile.level)


def _factor(profile: Profile) -> float:
    """Return how many units of a figure are one SI unit of a profile."""
    factor = shown_unit(profile.signal_unit)[1]
    return factor**2 if _is_density(profile) else factor


def _is_density(profile: Profile) -> bool:
    return profile.unit.endswith("/Hz")


def _decibels(profile: Profile, ratio: FloatArray) -> FloatArray:
    return np.array((10.0 if _is_density(profile) else 20.0) * np.log10(ratio))


def lines_of(profile: Profile, frequency: FloatArray) -> dict[str, FloatArray]:
    """Return the alarm and abort lines at some frequencies, lowered where a notch allows it.

    Parameters
    ----------
    profile : Profile
        The profile.
    frequency : (n_points,) array
        Where [Hz].

    Returns
    -------
    dict
        (n_points,) array of each of `LINES` [unit of the profile].
    """
    demand = profile_at(frequency, *_points(profile))
    at = np.searchsorted(np.array(profile.frequency_hz), frequency, side="right") - 1
    at = np.clip(at, 0, len(profile.frequency_hz) - 1)
    depth = np.zeros(frequency.shape)
    for notch in profile.notches:
        inside = (frequency >= notch.low) & (frequency <= notch.high)
        depth[inside] = np.maximum(depth[inside], notch.depth)
    per_decade = 10.0 if _is_density(profile) else 20.0
    tolerance = {
        "alarm": np.array(profile.alarm_db)[at],
        "abort": np.array(profile.abort_db)[at],
    }
    return {
        name: demand
        * 10.0 ** ((side * tolerance[look] - (depth if side < 0 else 0.0)) / per_decade)
        for name, (look, side) in LINES.items()
    }


def _judged(result: RunResult, profile: Profile, rows: Sequence[int]) -> JudgedControl:
    """Return the curve that is compared with the profile, where both are."""
    if _is_density(profile):
        return _judged_density(result, profile, rows)
    return _judged_sweep(result, profile)


def _judged_density(result: RunResult, profile: Profile, rows: Sequence[int]) -> JudgedControl:
    frequency = result.spectra.frequency
    edge = flags.EDGE_BINS * result.spectra.bin_width
    low = max(profile.frequency_hz[0], result.band[0])
    high = min(profile.frequency_hz[-1], result.band[1])
    inside = (frequency > low + edge) & (frequency < high - edge)
    unit = result.channels[rows[0]].unit
    return JudgedControl(
        frequency[inside],
        result.averages.psd[list(rows)].mean(axis=0)[inside],
        {
            result.channels[i].name: result.averages.psd[i][inside]
            for i in result.responses
            if result.channels[i].unit == unit and i not in rows
        },
        result.spectra,
    )


def _judged_sweep(result: RunResult, profile: Profile) -> JudgedControl:
    sweeps = result.over_time.tracking.sweeps
    parts = [
        (s.frequency[inner], s.control[inner], np.abs(s.harmonics[:, 0])[:, inner])
        for s in sweeps
        for inner in [flags.inner_part(s)]
    ]
    frequency = np.concatenate([p[0] for p in parts] or [np.zeros(0)])
    control = np.concatenate([p[1] for p in parts] or [np.zeros(0)])
    inside = (frequency >= profile.frequency_hz[0]) & (frequency <= profile.frequency_hz[-1])
    inside &= np.isfinite(control) & (control > 0.0)
    unit = result.channels[result.controls[0]].unit if result.controls else ""
    return JudgedControl(
        frequency[inside],
        control[inside],
        {
            result.channels[i].name: np.concatenate([p[2][i] for p in parts])[inside]
            for i in result.responses
            if parts and result.channels[i].unit == unit
        },
        None,
    )


def _verdict(
    name: str, line: FloatArray, judged: JudgedControl, profile: Profile
) -> dict[str, Cell]:
    """Return by how much the control lies beyond a line at worst, and whether that is kept.

    An abort line is kept where no line or band lies beyond it by more than chance; an alarm
    line where 5 % of the lines do at most.
    """
    look, side = LINES[name]
    with np.errstate(divide="ignore"):
        beyond = side * _decibels(profile, judged.control / line)
    worst = int(np.argmax(beyond))
    sure = beyond > 0.0
    if judged.spectra is not None:
        ratio, anywhere = judged.control / line, look == "abort"
        sure = surely_beyond(ratio, judged.spectra, above=side > 0, anywhere=anywhere)
    share = float(np.mean(sure))
    allowed = BEYOND_ALARM if look == "alarm" else 0.0
    return {
        "profile": profile.name,
        "line": name,
        "exceedance_db": float(np.clip(beyond[worst], -999.0, 999.0)),
        "at_hz": float(judged.frequency[worst]),
        "beyond_share": share,
        "allowed_share": allowed,
        "kept": share <= allowed,
    }


def _verdict_text(summary: Sequence[Mapping[str, Cell]], profile: Profile) -> str:
    """Return the verdict in a sentence."""
    broken = [str(row["line"]) for row in summary if not row["kept"]]
    verdict = f"NOT KEPT ({', '.join(broken)})" if broken else "kept"
    return f"Profile {profile.name}: {verdict}."


def _broken(row: Mapping[str, Cell], profile: Profile) -> str:
    """Return the message on a line that was not kept."""
    share, allowed = (
        100.0 * float(row[key] or 0.0) for key in ("beyond_share", "allowed_share")
    )
    return (
        f"the control does not keep the {row['line']} line of profile {profile.name}: "
        f"{row['exceedance_db']:+.1f} dB beyond it at {numeral(row['at_hz'], 4)} Hz. "
        f"{rounded_within(share, allowed, sign=False)} % of the band lie beyond it by more "
        f"than chance, where {allowed:g} % may"
    )


def _rms_band(result: RunResult, profile: Profile) -> tuple[float, float]:
    return profile.frequency_hz[0], min(
        profile.frequency_hz[-1], result.recorded.sample_rate / 2.0
    )


def _rms(result: RunResult, profile: Profile, rows: Sequence[int]) -> dict[str, Cell]:
    """Return the rms of the demand beside that of the control; nothing for a sweep."""
    if not _is_density(profile):
        return {}
    band = _rms_band(result, profile)
    each = spectra.rms_in_band(result.spectra, band)[list(rows)]
    unit, factor = shown_unit(result.channels[rows[0]].unit)
    return {
        "demand_rms": profile_rms(*_points(profile), band) * factor,
        "measured_rms": float(np.sqrt(np.mean(each**2))) * factor,
        "unit": unit,
    }


def _rms_text(rms: Mapping[str, Cell], band: tuple[float, float]) -> tuple[str, ...]:
    """Return the comparison of the rms in a sentence, if there is one to say."""
    if not rms:
        return ()
    demanded, seen = (float(rms[name] or 0.0) for name in ("demand_rms", "measured_rms"))
    off = f" ({20.0 * np.log10(seen / demanded):+.2f} dB)" if seen > 0.0 else ""
    return (
        f"Demanded {numeral(demanded, 4)} {rms['unit']} rms from {band[0]:g} to {band[1]:g} "
        f"Hz, measured {numeral(seen, 4)} {rms['unit']} rms{off}.",
    )


def _columns(
    judged: JudgedControl, demand: FloatArray, lines: Mapping[str, FloatArray], profile: Profile
) -> dict[str, FloatArray]:
    factor = _factor(profile)
    ending = _ending(profile)
    values = {"demand": demand, **lines, "control": judged.control, **judged.responses}
    return {
        "frequency_hz": judged.frequency,
        **{f"{k.replace(' ', '_')}{ending}": v * factor for k, v in values.items()},
    }


def _ending(profile: Profile) -> str:
    unit = shown_unit(profile.signal_unit)[0]
    return spelled(unit, power=2 if _is_density(profile) else 1)


def _corners(profile: Profile) -> FloatArray:
    """Return where the lines bend or jump [Hz], jumps from both sides."""
    points = np.array(profile.frequency_hz)
    ends = np.array([n for notch in profile.notches for n in (notch.low, notch.high)])
    jumps = np.concatenate([ends, points[1:-1]])
    x = np.unique(np.concatenate([points, jumps * (1.0 - 1e-9), jumps * (1.0 + 1e-9)]))
    return np.array(x[(x >= points[0]) & (x <= points[-1])])


def _panel(judged: JudgedControl, profile: Profile, result: RunResult) -> Panel:
    """Return control and responses over the lines, which are drawn at their own corners."""
    factor, (points, levels_there) = _factor(profile), _points(profile)
    x = _corners(profile)
    drawn = [PanelLine("demand", points, levels_there * factor, look="demand")]
    drawn += [
        PanelLine(look if side > 0 else "", x, y * factor, look=look)
        for y, (look, side) in zip(lines_of(profile, x).values(), LINES.values(), strict=True)
    ]
    order = np.argsort(judged.frequency, kind="stable")
    f = judged.frequency[order]
    drawn += [
        PanelLine(name, f, y[order] * factor, channel=name)
        for name, y in judged.responses.items()
    ]
    control = result.channels[result.controls[0]].name if result.controls else ""
    drawn.append(PanelLine("control", f, judged.control[order] * factor, channel=control))
    unit = shown_unit(profile.signal_unit)[0]
    density = _is_density(profile)
    return Panel(
        name="profile",
        title=f"Profile {profile.name}",
        caption="Mean control and responses over demand, alarm and abort lines.",
        x=PanelScale("frequency [Hz]"),
        y=PanelScale(f"PSD [{unit}²/Hz]" if density else f"amplitude [{unit}]"),
        lines=tuple(drawn),
    )
