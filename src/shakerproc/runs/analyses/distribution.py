"""Probability density and exceedance of every channel, beside those of the normal law."""

from typing import ClassVar, Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray, Recording
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.spectra import Statistics

FAR: Final = 3.0
"""Deviation, over the standard deviation, beyond which samples are counted: 0.27 % of a normal
law, and where a shaker's limiter cuts [-]."""

_CAPTION: Final = "Dashed: a normal law."


@final
class DistributionAnalysis(AbstractAnalysis):
    """How often samples deviate from their mean, and by how much."""

    kind: ClassVar[str] = "distribution"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the distributions of a run."""
        wanted = result.test.processing.distribution
        if wanted is None:
            return None
        statistics = result.averages.statistics
        edges = _edges(statistics, wanted.bins)
        counts, beyond = _counted(recording, result, edges)
        density = counts / (result.crop.n_samples * np.diff(edges))
        above = counts[:, ::-1].cumsum(axis=1)[:, ::-1] / result.crop.n_samples
        moving = [i for i in range(len(counts)) if statistics.standard_deviation[i] > 0.0]
        names = [channel.name for channel in result.channels]
        columns = {"from_sigma": edges[:-1], "to_sigma": edges[1:]}
        for i in moving:
            columns[f"density_{names[i]}_per_sigma"] = density[i]
            columns[f"exceedance_{names[i]}"] = above[i]
        return Analysis(
            kind=self.kind,
            title="Probability density and exceedance",
            columns=columns,
            summary=tuple(_row(result, i, beyond[i]) for i in range(len(counts))),
            panels=_panels(edges, [(names[i], density[i], above[i]) for i in moving]),
        )


def _edges(statistics: Statistics, bins: int) -> FloatArray:
    """Return the ends of the intervals, deviations over the standard deviation [-]."""
    spread = statistics.standard_deviation
    moving = spread > 0.0
    if not moving.any():
        return np.linspace(-FAR, FAR, bins + 1)
    least = (statistics.minimum - statistics.mean)[moving] / spread[moving]
    most = (statistics.maximum - statistics.mean)[moving] / spread[moving]
    return np.linspace(float(least.min()), float(most.max()), bins + 1)


def _counted(
    recording: Recording, result: RunResult, edges: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return samples in each interval, (n_channels, n_bins), and far out, (n_channels,)."""
    statistics = result.averages.statistics
    spread = np.where(statistics.standard_deviation > 0.0, statistics.standard_deviation, 1.0)
    counts = np.zeros((len(result.channels), edges.size - 1))
    beyond = np.zeros(len(result.channels))
    ends = edges + np.array([-1e-9, *np.zeros(edges.size - 2), 1e-9])  # rounding of extremes
    for block in recording.blocks(result.crop.start, result.crop.stop):
        deviation = (block - statistics.mean[:, np.newaxis]) / spread[:, np.newaxis]
        beyond += np.sum(np.abs(deviation) > FAR, axis=1)
        counts += [np.histogram(row, ends)[0] for row in deviation]
    return counts, beyond


def _row(result: RunResult, i: int, beyond: float) -> dict[str, Cell]:
    statistics, channel = result.averages.statistics, result.channels[i]
    unit, factor = shown_unit(channel.unit)
    moves = bool(statistics.standard_deviation[i] > 0.0)
    return {
        "channel": channel.name,
        "standard_deviation": float(statistics.standard_deviation[i]) * factor,
        "unit": unit,
        "crest_factor": float(statistics.crest_factor[i]) if moves else None,
        "kurtosis": float(statistics.kurtosis[i]) if moves else None,
        "beyond_3_sigma": beyond / result.crop.n_samples if moves else None,
    }


def _panels(
    edges: FloatArray, rows: list[tuple[str, FloatArray, FloatArray]]
) -> tuple[Panel, ...]:
    """Return densities and exceedances against the deviation, with those of the normal law."""
    middle, low, normal = 0.5 * (edges[:-1] + edges[1:]), edges[:-1], scipy.stats.norm
    densities = [_line(name, middle, density) for name, density, _ in rows]
    above = [_line(name, low, share) for name, _, share in rows]
    densities.append(PanelLine("normal law", middle, normal.pdf(middle), look="demand"))
    above.append(PanelLine("normal law", low, normal.sf(low), look="demand"))
    deviation = PanelScale("deviation from the mean [standard deviations]", logarithmic=False)
    return (
        Panel(
            "distribution_density", "Probability density", _CAPTION, deviation,
            PanelScale("density [1/standard deviation]"), tuple(densities),
        ),
        Panel(
            "distribution_exceedance", "Exceedance", _CAPTION, deviation,
            PanelScale("share of samples at or above [-]"), tuple(above),
        ),
    )  # fmt: skip


def _line(name: str, x: FloatArray, y: FloatArray) -> PanelLine:
    return PanelLine(name, x, np.where(y > 0.0, y, np.nan), channel=name)
