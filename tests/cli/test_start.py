"""What the everyday command loads: what it does not need would cost a second."""

import subprocess
import sys

import numpy as np
from tests.small_campaign import write_campaign

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.recordings import write_tdms

LATE = {
    "numba",
    "pandas",
    "matplotlib",
    "jinja2",
    "pint",
    "scipy.signal",
    "scipy.stats",
}


def test_random_vibration_without_figures_loads_no_compiler(tmp_path):
    """With peaks and their damping, bounds and health: what most recordings need."""
    rng = np.random.default_rng(3)
    n, rate = 2**17, 2048.0
    base = rng.standard_normal(n)
    ratio = np.fft.rfftfreq(n, 1.0 / rate) / 150.0
    gain = (1 + 0.04j * ratio) / (1 - ratio**2 + 0.04j * ratio)
    response = np.fft.irfft(np.fft.rfft(base) * gain, n)
    channels = [Channel(name, "m/s^2", name, "m/s^2") for name in ("control 1", "tip")]
    samples = np.array([base, response + 0.01 * rng.standard_normal(n)])
    write_tdms(tmp_path / "a.tdms", recording_of_arrays("a", channels, samples, rate))
    code = (
        "import sys; import shakerproc.cli as cli\n"
        "sys.argv = 'shakerproc process a.tdms --excitation random --no-crop --no-figures'\n"
        "sys.argv = [*sys.argv.split(), '--out', 'out']\n"
        "try: cli.main()\n"
        "finally: print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
    )
    assert "zeta" in done.stdout  # a damping was fitted
    assert not LATE & set(done.stderr.split())


def test_a_batch_without_figures_loads_no_pandas(tmp_path):
    """What is loaded to write Parquet; reports are made with Jinja."""
    log = write_campaign(tmp_path, 1, seconds=2.0)
    code = (
        "import sys; import shakerproc.cli as cli\n"
        f"sys.argv = ['shakerproc', 'batch', {str(log)!r}, '--no-figures', '--workers', '1']\n"
        "try: cli.main()\n"
        "finally: print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert (tmp_path / "results" / "peaks.parquet").is_file()
    late = (LATE - {"jinja2"}) | {"scipy.optimize"}
    assert not late & set(done.stderr.split())
