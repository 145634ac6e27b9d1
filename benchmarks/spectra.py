"""The cross-spectral matrix against scipy's calls and against the bare FFTs, in one run.

python -m benchmarks.spectra [--samples 20000000] [--repeats 5] [--no-scipy]
"""

import argparse
import importlib.metadata
import multiprocessing
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from scipy import fft

CHANNELS, SEGMENT, STEP, RATE = 5, 1024, 512, 5688.9
GROUP = 25


def recording(n_samples: int) -> np.ndarray:
    """Return white noise, (5, n_samples)."""
    return np.random.default_rng(1).standard_normal((CHANNELS, n_samples))


def ours(samples: np.ndarray) -> None:
    """Compute the full matrix in one pass."""
    from shakerproc.spectra import cross_spectra

    cross_spectra(samples, RATE, segment=SEGMENT)


def bare_transforms(samples: np.ndarray) -> None:
    """Compute as many FFTs of that length, of a buffer that stays in the cache."""
    buffer = samples[:, : GROUP * SEGMENT].reshape(GROUP, CHANNELS, SEGMENT).copy()
    for _ in range(((samples.shape[1] - SEGMENT) // STEP + 1) // GROUP):
        fft.rfft(buffer)


def usual_calls(samples: np.ndarray) -> None:
    """Compute what a script does: five welch, three csd, three coherence."""
    from scipy import signal

    options = {"fs": RATE, "window": np.hamming(SEGMENT), "nperseg": SEGMENT, "detrend": False}
    control = (samples[0] + samples[1]) / 2.0
    for row in samples:
        signal.welch(row, **options)
    for row in samples[2:]:
        signal.csd(control, row, **options)
        signal.coherence(control, row, **options)


def seconds(work: Callable[[np.ndarray], None], samples: np.ndarray) -> float:
    """Return how long one call takes [s]."""
    start = time.perf_counter()
    work(samples)
    return time.perf_counter() - start


def extra_memory(work: Callable[[np.ndarray], None], n_samples: int) -> float | None:
    """Return the peak memory of a call on top of its data [MB], where Linux tells it."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_extra_memory, (work, n_samples))


def _extra_memory(work: Callable[[np.ndarray], None], n_samples: int) -> float | None:
    status, reset = Path("/proc/self/status"), Path("/proc/self/clear_refs")
    if not status.exists():
        return None
    import shakerproc.spectra.kernels  # noqa: F401  (its memory is the same for any data)

    work(recording(100_000))
    samples = recording(n_samples)
    reset.write_text("5")
    before = _kilobytes(status, "VmRSS")
    work(samples)
    return (_kilobytes(status, "VmHWM") - before) / 1000.0


def _kilobytes(status: Path, key: str) -> float:
    line = next(line for line in status.read_text().splitlines() if line.startswith(key))
    return float(line.split()[1]) * 1.024


def main(arguments: Sequence[str] | None = None) -> None:
    """Print times, ratios and memory."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=20_000_000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument(
        "--no-scipy", action="store_true", help="leave out scipy, which is slow"
    )
    options = parser.parse_args(arguments)
    samples = recording(options.samples)
    ours(samples[:, :100_000])
    pairs = [
        (seconds(ours, samples), seconds(bare_transforms, samples))
        for _ in range(options.repeats)
    ]
    best, bare = (min(column) for column in zip(*pairs, strict=True))
    rate = options.samples / best / 1e6
    print(
        f"{CHANNELS} channels x {options.samples / 1e6:g} M samples, {SEGMENT}/{STEP} hamming"
    )
    print(f"full matrix {best:.2f} s ({rate:.0f} M samples/s), bare FFTs {bare:.2f} s")
    print(f"matrix over bare FFTs   {best / bare:6.2f}   (aim: at most 2)")
    if not options.no_scipy:
        usual = seconds(usual_calls, samples)
        version = importlib.metadata.version("scipy")
        print(f"scipy {version}, 5 welch + 3 csd + 3 coherence: {usual:.1f} s")
        print(
            f"scipy over matrix       {usual / best:6.1f}   (aim: at least 20, 10 before 1.16)"
        )
    del samples
    memory = extra_memory(ours, options.samples)
    if memory is not None:
        print(f"memory on top of data   {memory:6.0f} MB (aim: below 100)")


if __name__ == "__main__":
    main()
