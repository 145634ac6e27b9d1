"""Draw the pictures of README.md and the tutorial, as the commands shown there do.

python docs/make_images.py            # into docs/images
python docs/make_images.py FOLDER     # elsewhere; a test compares them with those kept
"""

import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
COLOURS = 64
BATCH = {
    "trends/figure_5_45_omega_e_against_clearance_random.png": "trend.png",
    "runs/test_3/psd_and_response.png": "test_3_psd_and_response.png",
    "runs/test_12/sweep.png": "test_12_sweep.png",
}
TUTORIAL = {
    "results/trends/omega_e_against_level_g2_per_hz.png": "tutorial_trend.png",
    "before/response_ch3.png": "tutorial_response_before.png",
    "before/restoring_force_base_coupon.png": "restoring_force.png",
    "after/response_ch3.png": "tutorial_response_after.png",
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
        picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(
            target, optimize=True
        )


def main() -> None:
    """Run the commands, and keep some of their pictures."""
    if len(sys.argv) > 2:
        draw(Path(sys.argv[1]), Path(sys.argv[2]))
        return
    with tempfile.TemporaryDirectory() as name:
        draw(IMAGES, Path(name))


def draw(images: Path, folder: Path) -> None:
    """Work the sample data and a new campaign through below a folder; fill the images."""
    shakerproc("batch", ROOT / "sample_data" / "testlog.yaml", "--out", folder / "batch")
    shakerproc("init", folder / "campaign")
    model, log = folder / "campaign" / "model.yaml", folder / "campaign" / "testlog.yaml"
    shakerproc("batch", log, "--out", folder / "results")
    shakerproc("compare", model, log, "--out", folder / "before")
    shakerproc("add", "gap", model, log, "-o", folder / "with-gap.yaml")
    shakerproc("compare", folder / "with-gap.yaml", log, "--out", folder / "after")
    for source, target in BATCH.items():
        keep(folder / "batch" / source, images / target)
    for source, target in TUTORIAL.items():
        keep(folder / source, images / target)


if __name__ == "__main__":
    main()
