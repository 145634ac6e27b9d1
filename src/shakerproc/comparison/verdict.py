"""Where the model fails, in one sentence."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.comparison.comparison import Comparison, TestComparison
from shakerproc.comparison.errors import Pair
from shakerproc.comparison.joints import by_range
from shakerproc.comparison.noise import EXCESS
from shakerproc.models.motion import shown_in
from shakerproc.numerals import numeral
from shakerproc.runs.levels import AMPLITUDE_TOLERANCE, Level, demanded

SMALL: Final = 0.03
"""Error that passes where the noise is unknown [-]."""

_GROWS: Final = 1.3  # from the lowest to the highest level
_SHIFT_BINS: Final = 1.5
_DEVIATIONS: Final = 2.0  # standard deviations of a change: 95 %
_LEAST: Final = 1e-3  # coherence: below it a gain is noise alone


def explained(comparison: Comparison) -> bool:
    """Return whether the model leaves no more than noise of every test."""
    return all(map(_passes, comparison.tests))


def sentence(comparison: Comparison) -> str:
    """Return where and how the model fails, or that it does not."""
    if explained(comparison):
        return _explained(comparison)
    worst = max(comparison.tests, key=_excess)
    parts = [
        _failure(comparison, worst),
        _joint(comparison, worst),
        _levels(comparison),
        _drift(worst),
    ]
    return " ".join(part for part in parts if part)


def _excess(test: TestComparison) -> float:
    """Return how far an error stands above what can be asked."""
    return test.error / (EXCESS * test.noise) if _noisy(test) else test.error / SMALL


def _noisy(test: TestComparison) -> bool:
    """Return whether the noise is known."""
    return bool(np.isfinite(test.noise)) and test.noise > 1e-6


def _passes(test: TestComparison) -> bool:
    return _excess(test) <= 1.0


def _explained(comparison: Comparison) -> str:
    noisy = [test for test in comparison.tests if _noisy(test)]
    how = f"the error is {numeral(comparison.error, 2)} of the response"
    if noisy:
        times = max(test.error / test.noise for test in noisy)
        how = f"the error is nowhere more than {numeral(times, 2)} times the noise"
    fitted = " with its numbers fitted" if comparison.refit else ""
    return f"The model explains every test{fitted}: {how}."


def _failure(comparison: Comparison, worst: TestComparison) -> str:
    """Say how much is left, of which sensor, and where in frequency."""
    i = int(np.argmax([error.error for error in worst.errors]))
    errors, name = worst.errors[i], worst.measured.sensors[i]
    index = comparison.tests.index(worst)
    share, edges = comparison.bands.share[index, i], comparison.bands.edges
    first, last = _narrowest(share)
    noise = f" (noise {worst.noise:.2%})" if _noisy(worst) else ""
    fitted = ", its numbers fitted," if comparison.refit else ""
    text = (
        f"The model{fitted} fails most in test {worst.measured.name}"
        f"{_level(worst)}: the residual rms of {name} is {errors.error:.1%} of its "
        f"measured rms{noise}, "
        f"{share[first : last + 1].sum():.0%} of its power between {numeral(edges[first])} and "
        f"{numeral(edges[last + 1])} Hz"
    )
    bin_width = worst.pair.resolution
    if abs(errors.peak_hz - errors.peak_model_hz) > _SHIFT_BINS * bin_width:
        return (
            f"{text}; the response peaks at {numeral(errors.peak_hz, 4)} Hz, the model at "
            f"{numeral(errors.peak_model_hz, 4)} Hz."
        )
    ratio = errors.peak_model_gain / errors.peak_gain if errors.peak_gain > 0.0 else 1.0
    if abs(np.log(ratio)) > 0.1:
        return (
            f"{text}; at the resonance its gain is {numeral(ratio, 2)} times the measured one."
        )
    return f"{text}."


def _level(test: TestComparison) -> str:
    """Return the level in brackets, without that of a noise density's decimals."""
    text = test.measured.test.level_text
    return f" ({text})" if text else ""


def _narrowest(share: np.ndarray) -> tuple[int, int]:
    """Return the fewest neighbouring bands that hold two thirds of what is left."""
    total = share.sum()
    for width in range(1, share.size + 1):
        sums = np.convolve(share, np.ones(width), "valid")
        if sums.max() >= 2.0 / 3.0 * total:
            first = int(np.argmax(sums))
            return first, first + width - 1
    return 0, share.size - 1


def _joint(comparison: Comparison, worst: TestComparison) -> str:
    """Say at which displacements the force is missing, in the joint that lacks most."""
    if not worst.joints:
        return ""
    lacks = [
        float(np.sqrt(np.mean((j.force - j.force_model) ** 2) / (np.mean(j.force**2) or 1.0)))
        for j in worst.joints
    ]
    joint = worst.joints[int(np.argmax(lacks))]
    lack = by_range(joint, joint.displacement)
    known = np.isfinite(lack.mean)
    size = np.abs(np.where(known, lack.mean, 0.0))
    far = np.abs(lack.centre)
    outer = far > 0.5 * far.max()
    places = " and ".join(joint.between)
    text = f"Between {places} the modelled force misses {max(lacks):.1%} rms"
    inner_size = float(size[~outer & known].max(initial=0.0))
    outer_size = float(size[outer & known].max(initial=0.0))
    if outer_size > 2.0 * inner_size:
        reach = 0.5 * float(far.max())
        unit, factor = shown_in("m", comparison.model.motion, reach)
        return f"{text}, most beyond a displacement of {numeral(reach * factor, 2)} {unit}."
    return f"{text}."


def _levels(comparison: Comparison) -> str:
    """Say whether the error depends on the level, where one kind of test has several."""
    alike = max(_by_level(comparison), key=len)
    if len(alike) < 2:
        return (
            "All tests have one level, so what depends on amplitude cannot be told from what "
            "does not."
        )
    low, high = alike[0], alike[-1]
    span = f"from {low.told} to {high.told}"
    if high.error > _GROWS * low.error:
        return f"The error grows with the level, {span}: something depends on amplitude."
    if low.error > _GROWS * high.error:
        return f"The error falls with the level, {span}: friction or noise would do that."
    same = f"The error is much the same at every level, {span}"
    change = _change(low.test, high.test)
    if change is None:  # an error near 1 is large at every level, whatever is missing
        return f"{same}."
    if change.unfollowed:
        return f"{same}, but {change.told}: something depends on amplitude."
    return f"{same}." if comparison.refit else f"{same}: fit the numbers first (--fit)."


@final
@dataclass(frozen=True, slots=True)
class _Change:
    """How far response functions differ between two levels, of one sensor.

    Attributes
    ----------
    sensor : str
        Its name.
    measured, model : float
        Rms change of the response function over its rms, both weighted with the input [-].
    unfollowed : bool
        Whether the model leaves more of the change than random errors make.
    """

    sensor: str
    measured: float
    model: float
    unfollowed: bool

    @property
    def told(self) -> str:
        return (
            f"the response function of {self.sensor} changes by {self.measured:.0%} and the "
            f"model's by {self.model:.0%}"
        )


def _change(low: TestComparison, high: TestComparison) -> _Change | None:
    r"""Return the change of the sensor whose response function the model follows least.

    .. math:: D^2 = \frac{\sum_f |\Delta H - \Delta \hat H|^2 G_{xx}}
        {\sum_f |H|^2 G_{xx}}, \qquad
        \mathrm{var}\, H = \frac{1 - \gamma^2}{\gamma^2 n_d} |H|^2

    with :math:`\Delta` between two levels; unlike the free-run error it does not end at 1 where
    two motions have nothing in common. None where the tests share no excited line.
    """
    one, other = low.pair, high.pair
    low_hz, high_hz = (
        pick(a, b)
        for pick, a, b in zip(
            (max, min), low.measured.excited, high.measured.excited, strict=True
        )
    )
    f = one.frequency[one.excited & (one.frequency >= low_hz) & (one.frequency <= high_hz)]
    if not f.size or not other.excited.any():
        return None

    def at(pair: Pair, rows: np.ndarray, i: int) -> np.ndarray:
        return np.asarray(np.interp(f, pair.frequency, rows[i]))

    weight = np.interp(f, one.frequency, one.input)
    changes = []
    for i, name in enumerate(low.measured.sensors):
        h_low, h_high = at(one, one.h1, i), at(other, other.h1, i)
        change = h_high - h_low
        model = at(other, other.h1_model, i) - at(one, one.h1_model, i)
        random = np.zeros(f.size)
        for pair in (one, other):
            for h1, coherence in (
                (pair.h1, pair.coherence), (pair.h1_model, pair.coherence_model)
            ):  # fmt: skip
                known = np.maximum(at(pair, coherence, i), _LEAST)
                random += np.abs(at(pair, h1, i)) ** 2 * (1.0 - known) / (known * pair.averages)
        size = np.sqrt(np.sum(np.abs(h_low) ** 2 * weight)) or 1.0
        left, noise = (
            np.sqrt(np.sum(v * weight)) / size for v in (np.abs(change - model) ** 2, random)
        )
        measured, modelled = (
            float(np.sqrt(np.sum(np.abs(v) ** 2 * weight)) / size) for v in (change, model)
        )
        unfollowed = bool(left > _DEVIATIONS * noise)
        changes.append((left, _Change(name, measured, modelled, unfollowed)))
    return max(changes, key=lambda pair: pair[0])[1]


@final
@dataclass(frozen=True, slots=True)
class _AtLevel:
    """A test at its level, with its error."""

    level: Level
    text: str
    error: float
    test: TestComparison

    @property
    def told(self) -> str:
        return f"{self.error:.1%} ({self.text})"


def _by_level(comparison: Comparison) -> list[list[_AtLevel]]:
    """Return the tests that can be compared, one for each level, lowest first.

    Those of one kind of excitation whose levels have one unit: as the log says them or, where
    it does not say all, as the input was measured.
    """
    kinds: dict[str | None, list[TestComparison]] = {}
    for test in comparison.tests:
        kinds.setdefault(test.measured.test.excitation, []).append(test)
    unit = comparison.model.drive_unit
    found: list[list[_AtLevel]] = []
    for tests in kinds.values():
        said = [demanded(test.measured.test) for test in tests]
        if None in said:
            seen = [_seen(test, unit) for test in tests]
            found.append(_apart(seen, AMPLITUDE_TOLERANCE))
            continue
        groups: dict[tuple[str, str], list[_AtLevel]] = {}
        for test, level in zip(tests, said, strict=True):
            if level is not None:
                one = _AtLevel(level, test.measured.test.level_text, test.error, test)
                groups.setdefault((level.kind, level.unit), []).append(one)
        found += [_apart(group, 0.0) for group in groups.values()]
    return found


def _seen(test: TestComparison, unit: str) -> _AtLevel:
    """Return a test at the level of its measured input."""
    measured = test.measured
    part = measured.input[measured.start : measured.stop]
    level = Level("rms", float(np.sqrt(np.mean(part**2))), unit)
    return _AtLevel(level, str(level), test.error, test)


def _apart(tests: list[_AtLevel], tolerance: float) -> list[_AtLevel]:
    """Return the tests whose levels differ by more than this share, lowest first."""
    kept: list[_AtLevel] = []
    for test in sorted(tests, key=lambda test: test.level.value):
        if not kept or test.level.value > (1.0 + tolerance) * kept[-1].level.value:
            kept.append(test)
    return kept


def _drift(worst: TestComparison) -> str:
    """Say whether the error grows during the test, where no sweep explains that."""
    time = worst.time
    if worst.measured.test.excitation not in {"random", "multisine", "sine"}:
        return ""
    slope = float(time.slope[np.argmax(np.abs(time.slope))])
    if abs(slope) < 0.5:
        return ""
    way = "grows" if slope > 0.0 else "falls"
    return f"It {way} by {abs(slope):.0%} of its mean during the test."
