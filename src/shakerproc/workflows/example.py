"""A small campaign to begin with: a coupon whose joint has play, simulated and recorded."""

from importlib import resources
from pathlib import Path

from shakerproc import files


def write_example(folder: Path) -> tuple[Path, Path]:
    """Write recordings, a log and a model of them that lacks the gap; return log and model.

    They were simulated once, by `sample_data/make_example.py`.
    """
    shipped = resources.files("shakerproc.workflows") / "example_campaign"
    recordings = folder / "recordings"
    recordings.mkdir(parents=True, exist_ok=True)
    for recording in (shipped / "recordings").iterdir():
        files.write_bytes(recordings / recording.name, recording.read_bytes())
    log, model = folder / "testlog.yaml", folder / "model.yaml"
    for path in (log, model):
        files.write_text(path, (shipped / path.name).read_text(encoding="utf-8"))
    return log, model
