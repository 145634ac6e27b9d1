"""The check of a driving point: a force and a sensor in one place along one line."""

from collections.abc import Iterator
from typing import ClassVar, Final, final

from shakerproc.data import ChannelUse, Recording
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.panels import Analysis, Cell
from shakerproc.runs.result import RunResult, lone_force
from shakerproc.runs.roles import sense_of, uses_of
from shakerproc.spectra.responses import INTEGRATIONS, power_share

MUCH: Final = 0.5
"""Share of the power, net over gross, from which on it flows one way [-]: the middle between 1,
all goes in, and 0, where force and motion have nothing to do with each other."""


@final
class DrivingPointAnalysis(AbstractAnalysis):
    """Whether the force feeds power in where the log says that force and sensor meet."""

    kind: ClassVar[str] = "driving_point"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the check; None where no sensor sits at the place of a lone force."""
        force, uses = lone_force(result.channels), uses_of(recording, result.test)
        if force is None or not uses:
            return None
        shares = [
            (result.channels[row].name, _share(result, force, row, sense))
            for row, sense in _at_the_force(result, uses, force)
        ]
        if not shares:
            return None
        name = result.channels[force].name
        rows: tuple[dict[str, Cell], ...] = tuple(
            {"function": f"{sensor} / {name}", "power_in_percent": 100.0 * share}
            for sensor, share in shares
        )
        return Analysis(
            kind=self.kind,
            title="Driving point",
            columns={key: [row[key] for row in rows] for key in rows[0]},
            summary=rows,
            panels=(),
            sentences=("Power that the force feeds in where it acts, net over gross: 100 % if "
                       "all is the right way round.",),
            problems=tuple(text for one in shares if (text := _problem(name, *one))),
        )  # fmt: skip


def _at_the_force(
    result: RunResult, uses: list[ChannelUse], force: int
) -> Iterator[tuple[int, float]]:
    """Yield each sensor at the place of the force, and 1, or -1 where it faces against it."""
    place = (uses[force].position, uses[force].direction)
    for row, use in enumerate(uses):
        sense = sense_of(place, (use.position, use.direction))
        if row != force and sense and result.channels[row].unit in INTEGRATIONS:
            yield row, sense


def _share(result: RunResult, force: int, row: int, sense: float) -> float:
    """Return the share of the power that goes in, a hammer with negative blows turned round."""
    turned = (
        1.0
        if result.over_time.blows is None
        else float(result.over_time.blows.setup.strikes.sign)
    )
    unit = result.channels[row].unit
    return sense * turned * power_share(result.spectra, force, row, unit, result.band)


def _problem(force: str, sensor: str, share: float) -> str:
    """Return the fault of a driving point; empty where there is none."""
    if share >= MUCH:
        return ""
    if share <= -MUCH:
        return (
            f"{sensor} moves against {force} where both sit: one of them is the wrong way "
            "round. Turn its sign, or give both their direction in the log"
        )
    return (
        f"{sensor} and {force} do not fit each other as a driving point (power in net over "
        f"gross: {share:.0%}). They sit in two places, do not point along one line, or one is "
        "late"
    )
