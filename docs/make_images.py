"""Draw the pictures of README.md from sample_data, as the commands shown there do."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
BATCH = {
    "trends/figure_5_45_omega_e_against_clearance_random.png": "trend.png",
    "runs/test_3/psd_and_response.png": "test_3_psd_and_response.png",
    "runs/test_12/sweep.png": "test_12_sweep.png",
}
COMPARE = {"restoring_force_base_coupon.png": "restoring_force.png"}


def shakerproc(*arguments: object) -> None:
    """Run a command."""
    command = [sys.executable, "-m", "shakerproc", *map(str, arguments)]
    subprocess.run(command, check=True)  # noqa: S603 - our own program


def main() -> None:
    """Run batch, init and compare, and keep some of their pictures."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        out, campaign = Path(name) / "results", Path(name) / "campaign"
        shakerproc("batch", ROOT / "sample_data" / "testlog.yaml", "--out", out)
        shakerproc("init", campaign)
        model, log = campaign / "model.yaml", campaign / "testlog.yaml"
        shakerproc("compare", model, log, "--out", Path(name) / "compare")
        for folder, wanted in ((out, BATCH), (Path(name) / "compare", COMPARE)):
            for source, target in wanted.items():
                shutil.copyfile(folder / source, IMAGES / target)


if __name__ == "__main__":
    main()
