"""A weave that was killed, and one that was not, end in the same files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from giant.giants import needs

HERE = Path(__file__).parent
TESTS = str(HERE.parent)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills are tried where processes fork")
def test_weaves_killed_at_random_moments_end_as_if_nobody_had(tmp_path: Path, thorough: bool) -> None:
    """Fifty, up to three times each, in both formats; in a process without threads, which may fork."""
    needs("zarr")
    rounds = 50 if thorough else 9
    words = [sys.executable, "-W", "error", str(HERE / "kill_weave.py"), str(tmp_path), str(rounds)]
    around = os.environ | {"PYTHONPATH": os.pathsep.join([TESTS, os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=around)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 1.2 * rounds, "most of 3 weaves each must be killed before they are done"
