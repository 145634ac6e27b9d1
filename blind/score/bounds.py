"""Exact bounds of a share that was counted."""

from scipy import stats


def clopper_pearson(successes: int, trials: int, level: float = 0.95) -> tuple[float, float]:
    """Return the exact bounds of a probability, by the binomial distribution [-].

    References
    ----------
    .. [1] C. J. Clopper and E. S. Pearson, "The use of confidence or fiducial limits
       illustrated in the case of the binomial", Biometrika 26, 404-413, 1934.
    """
    tail = 0.5 * (1.0 - level)
    low, high = 0.0, 1.0
    if successes > 0:
        low = float(stats.beta.ppf(tail, successes, trials - successes + 1))
    if successes < trials:
        high = float(stats.beta.ppf(1.0 - tail, successes + 1, trials - successes))
    return low, high
