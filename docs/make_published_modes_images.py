"""Process four published measurements and draw docs/how-to/published_modes.md.

python docs/make_published_modes_images.py FOLDER

The recordings are read from ../shared/data (SOURCES.md there says where they come from); FOLDER
gets them as the logs of configs/published_modes want them, and the results of the commands.
"""

import shutil
import sys
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from scipy import io

from shakerproc.cli import main as command
from shakerproc.spectra import cross_spectra, h1

mpl.use("Agg")

ROOT = Path(__file__).resolve().parents[1]
DATA, IMAGES = ROOT.parent / "shared" / "data", ROOT / "docs" / "images"
SETS = ("f16", "cued_gc4", "bobcat", "tower")


def convert(folder: Path) -> None:
    """Write logs and recordings of the four sets."""
    recordings = folder / "recordings"
    recordings.mkdir(parents=True, exist_ok=True)
    for log in (ROOT / "configs" / "published_modes").glob("*.yaml"):
        shutil.copy(log, folder)
    table = np.genfromtxt(
        DATA / "f16_level1" / "F16Data_FullMSine_Level1.csv",
        delimiter=",", skip_header=1, usecols=(0, 2, 3, 4),
    ).T  # fmt: skip
    names = ("force", "point", "wing", "payload")
    np.savez(recordings / "f16.npz", fs=400.0, **dict(zip(names, table, strict=True)))
    rows = np.load(DATA / "cued_gc4" / "time_data.npz")["y"].T
    np.savez(recordings / "cued_gc4.npz", fs=1000.0, **{f"c{i}": v for i, v in enumerate(rows)})
    hammer, sensor = blow()
    np.savez(recordings / "bobcat.npz", fs=1280.0, hammer=hammer, sensor=sensor)
    shutil.copy(DATA / "tdms_owilab" / "good_tdms_1.tdms", recordings / "tower.tdms")


def blow() -> np.ndarray:
    """Return force and motion of the blow that the analyser kept."""
    content = io.loadmat(DATA / "bobcat_analyzer_vibrationtesting" / "case1.mat")
    return np.array([content[f"Time_chan_{i}"][:, 0] for i in (1, 2)], dtype=float)


def run(*arguments: str) -> None:
    """Run a command as a person would.

    Raises
    ------
    SystemExit
        If it fails.
    """
    sys.argv = ["shakerproc", *arguments]
    try:
        command()
    except SystemExit as done:
        if done.code:
            raise


def cued() -> None:
    """Draw the authors' functions and those of the samples overlaid."""
    samples = np.load(DATA / "cued_gc4" / "time_data.npz")["y"].T
    stored = np.load(DATA / "cued_gc4" / "tf_data.npz")
    spectra = cross_spectra(
        samples,
        1000.0,
        segment=12728,
        overlap=6364,
        window="periodic hann",
        detrend="segment mean",
    )
    ours = h1(spectra, [0], range(1, 5))
    figure, axes = plt.subplots(2, 1, figsize=(8.0, 5.2), sharex=True, layout="constrained")
    for i in range(4):
        theirs = stored["y"][:, i]
        apart = np.abs(ours[i] - theirs) / np.abs(theirs)
        axes[1].semilogy(stored["f"], apart, lw=0.6, label=f"c{i + 1} / c0")
    axes[0].semilogy(stored["f"], np.abs(theirs), color="0.65", lw=2.5, label="authors")
    axes[0].semilogy(spectra.frequency, np.abs(ours[3]), lw=0.8, label="shakerproc")
    axes[0].set(ylabel="|H1| of c4 / c0", xlim=(40, 150), ylim=(0.3, 200))
    axes[1].set(xlabel="frequency [Hz]", ylabel="difference, relative")
    for axis in axes:
        axis.legend(fontsize=8)
    figure.savefig(IMAGES / "published_cued_gc4.png", dpi=90)


def bobcat() -> None:
    """Draw the analyser's averaged function and that of the last blow overlaid."""
    content = io.loadmat(DATA / "bobcat_analyzer_vibrationtesting" / "case1.mat")
    spectra = cross_spectra(blow(), 1280.0, segment=4096, window="rectangular")
    figure, axis = plt.subplots(figsize=(8.0, 3.8), layout="constrained")
    axis.semilogy(
        content["Freq_domain"].ravel(), np.abs(content["Hf_chan_2"].ravel()),
        color="0.65", lw=2.5, label="analyser, average of its blows",
    )  # fmt: skip
    last = np.abs(h1(spectra, [0], [1])[0])
    axis.semilogy(spectra.frequency, last, lw=0.8, label="shakerproc, the last blow")
    axis.set(xlim=(20, 500), xlabel="frequency [Hz]", ylabel="|H1|", ylim=(1, 1e5))
    axis.legend(fontsize=8)
    figure.savefig(IMAGES / "published_bobcat.png", dpi=90)


def main() -> None:
    """Process every set, and keep the pictures that the manual shows."""
    folder = Path(sys.argv[1]).resolve()
    convert(folder)
    for name in SETS:
        run("modal", str(folder / f"{name}.yaml"), "--out", str(folder / name))
    run("batch", str(folder / "f16.yaml"), "--out", str(folder / "f16_batch"))
    for picture, of in (
        ("f16/test_1_stabilisation", "f16_stabilisation"),
        ("f16/test_1_synthesis", "f16_synthesis"),
        ("tower/test_1_stabilisation", "tower_stabilisation"),
    ):
        shutil.copy(folder / f"{picture}.png", IMAGES / f"published_{of}.png")
    (noise,) = list((folder / "f16_batch").rglob("multisine_2.png"))
    shutil.copy(noise, IMAGES / "published_f16_multisine.png")
    cued()
    bobcat()


if __name__ == "__main__":
    main()
