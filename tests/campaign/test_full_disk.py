"""A disk that is really full: a small one is mounted in a namespace of its own."""

import json
import os
import shutil
import subprocess
import sys

import pytest
from tests.campaign.chaos import fingerprints
from tests.small_campaign import write_campaign

BATCH = f"{sys.executable} -m shakerproc batch --no-figures --workers 1 {{log}} --out {{out}}"
SCRIPT = """
mount -t tmpfs -o size={size}k tmpfs {out} || exit 99
{batch} 2> {said}
echo $? > {status}
cp -a {out} {full}
mount -o remount,size=200m {out}
{batch} || exit 98
cp -a {out} {after}
"""


def can_mount():
    if shutil.which("unshare") is None:
        return False
    try_it = ["unshare", "-rm", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    return subprocess.run(try_it, capture_output=True, check=False).returncode == 0


@pytest.mark.slow
@pytest.mark.skipif(not can_mount(), reason="no right to mount a small disk")
def test_a_full_disk_ends_a_batch_in_one_line_and_the_next_call_resumes(tmp_path):
    log, out = write_campaign(tmp_path, 2), tmp_path / "out"
    environment = os.environ | {"SOURCE_DATE_EPOCH": "1500000000"}
    batch = BATCH.format(log=log, out=out)
    # in a process of its own as well: the last digit of a sum depends on where arrays lie
    done = subprocess.run(
        batch.split(), env=environment, check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    calm = fingerprints(out)
    size = sum(p.stat().st_size for p in out.rglob("*") if p.is_file()) // 1024
    shutil.rmtree(out)
    out.mkdir()
    places = {name: tmp_path / name for name in ("said", "status", "full", "after")}
    script = SCRIPT.format(size=size // 2, out=out, batch=batch, **places)
    ended = subprocess.run(
        ["unshare", "-rm", "sh", "-c", script],
        env=environment,
        check=False,
        capture_output=True,
    )
    assert ended.returncode == 0, ended.stderr
    assert places["status"].read_text(encoding="utf-8") == "1\n"
    said = places["said"].read_text(encoding="utf-8").splitlines()
    assert "No space left on device; free some and call again" in said[-1]
    assert not [line for line in said if "Traceback" in line]
    manifest = json.loads((places["full"] / "manifest.json").read_text(encoding="utf-8"))
    found = fingerprints(places["full"])
    stands = {
        name: digest
        for entry in manifest["runs"].values()
        if entry["status"] == "done"
        for name, digest in entry["outputs"].items()
    }
    assert stands.items() <= found.items()
    written = {n: d for n, d in found.items() if n.startswith("runs/")}
    assert written.items() <= calm.items()
    assert fingerprints(places["after"]) == calm
