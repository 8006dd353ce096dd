"""The campaigns of `make fuzz`, a little of each, so that they keep running."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.parametrize(
    ("campaign", "words"),
    [("mutants", ["--count", "40", "--formats", "png,exr,jpeg,pnm"]), ("documents", ["--count", "8"])],
)
def test_a_campaign_finds_nothing(campaign: str, words: list[str], tmp_path: Path) -> None:
    paths = os.pathsep.join(filter(None, [str(HERE), os.environ.get("PYTHONPATH", "")]))
    done = subprocess.run(
        [sys.executable, "-m", f"hostile.{campaign}", *words, "--seed", "7"],
        capture_output=True, text=True, check=False, cwd=tmp_path, env=os.environ | {"PYTHONPATH": paths},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert all(json.loads(line)["failed"] == 0 for line in done.stdout.splitlines())
