"""A weave that was killed, and one that was not, end in the same files."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from giant.giants import files_below, needs

HERE = Path(__file__).parent
TESTS = str(HERE.parent)

PROCESSES = """
import sys
import intarsia as ia
from giant.giants import small
if __name__ == "__main__":
    small().to_zarr(sys.argv[1], (700, 640), chunk=16, executor="processes", run=ia.Run(2))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills are tried where processes fork")
def test_weaves_killed_at_random_moments_end_as_if_nobody_had(tmp_path: Path, thorough: bool) -> None:
    """Fifty, up to three times each, in all three formats; in a process without threads, which may fork."""
    needs("zarr")
    rounds = 50 if thorough else 9
    words = [sys.executable, "-W", "error", str(HERE / "kill_weave.py"), str(tmp_path), str(rounds)]
    around = os.environ | {"PYTHONPATH": os.pathsep.join([TESTS, os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=around)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 1.2 * rounds, "most of 3 weaves each must be killed before they are done"


def test_a_weave_by_processes_resumes_and_leaves_no_process(tmp_path: Path) -> None:
    """The workers of a killed weave end by themselves."""
    needs("zarr")
    script = tmp_path / "weave_it.py"
    script.write_text(PROCESSES)
    around = os.environ | {"PYTHONPATH": os.pathsep.join([TESTS, os.environ.get("PYTHONPATH", "")])}
    words = [sys.executable, str(script), str(tmp_path / "killed")]
    begun = subprocess.Popen(words, env=around)
    while begun.poll() is None and len(list((tmp_path / "killed").glob("c/*/*/0"))) < 2:
        time.sleep(0.01)
    children = Path(f"/proc/{begun.pid}/task/{begun.pid}/children")
    started = children.read_text().split() if children.exists() else []
    begun.send_signal(signal.SIGKILL)
    begun.wait()
    until = time.monotonic() + 20
    while any(running(pid) for pid in started) and time.monotonic() < until:
        time.sleep(0.05)
    assert not [pid for pid in started if running(pid)]
    assert subprocess.run(words, env=around, check=False).returncode == 0
    words[-1] = str(tmp_path / "whole")
    assert subprocess.run(words, env=around, check=False).returncode == 0
    assert files_below(tmp_path / "killed") == files_below(tmp_path / "whole")


def running(pid: str) -> bool:
    """Say whether a process runs; one that nobody has waited for does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
