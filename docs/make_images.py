"""Draw the pictures of README.md and the tutorial, as the commands shown there do.

python docs/make_images.py            # into docs/images
python docs/make_images.py FOLDER     # elsewhere
"""

import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
COLOURS = 128
BATCH = {
    "trends/peak_frequency_against_clearance_random.png": "trend.png",
    "runs/test_3/psd_and_response.png": "test_3_psd_and_response.png",
    "runs/test_12/sweep.png": "test_12_sweep.png",
}
TUTORIAL = {
    "campaign/results/trends/peak_frequency_against_level_g2_per_hz.png": "tutorial_trend.png",
    "comparison/response_ch3.png": "tutorial_response_before.png",
    "comparison/restoring_force_base_coupon.png": "restoring_force.png",
    "comparison_with_gap/response_ch3.png": "tutorial_response_after.png",
}


def shakerproc(*arguments: object) -> None:
    """Run a command."""
    command = [sys.executable, "-m", "shakerproc", *map(str, arguments)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # noqa: S603 - our own


def keep(source: Path, target: Path) -> None:
    """Keep a picture with few colours: lines and letters need no more."""
    from PIL import Image

    target.parent.mkdir(parents=True, exist_ok=True)
    with Image.open(source) as picture:
        few = picture.convert("RGB").quantize(
            COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
        )  # the median cut draws two lines in one colour
        few.save(target, optimize=True)


def sample(folder: Path) -> None:
    """Process the sample data below a folder."""
    shakerproc("batch", ROOT / "sample_data" / "testlog.yaml", "--out", folder / "batch")


def tutorial(folder: Path) -> None:
    """Process a new campaign below a folder, as the tutorial does."""
    model, log = folder / "campaign" / "model.yaml", folder / "campaign" / "testlog.yaml"
    extended = folder / "with-gap.yaml"
    shakerproc("init", folder / "campaign")
    shakerproc("batch", log)
    shakerproc("compare", model, log, "--out", folder / "comparison")
    shakerproc("add", "gap", model, log, "-o", extended)
    shakerproc("compare", extended, log, "--out", folder / "comparison_with_gap")


def pictures(folder: Path, images: Path) -> None:
    """Keep some of the pictures that `sample` and `tutorial` drew."""
    for source, target in BATCH.items():
        keep(folder / "batch" / source, images / target)
    for source, target in TUTORIAL.items():
        keep(folder / source, images / target)


def main() -> None:
    """Run the commands, and keep some of their pictures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sample(folder)
        tutorial(folder)
        pictures(folder, Path(sys.argv[1]) if len(sys.argv) > 1 else IMAGES)


if __name__ == "__main__":
    main()
