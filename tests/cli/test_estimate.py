"""What --dry-run tells of memory is within 25 % of what the whole process takes at its peak."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from long import but_some

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc tells the peak")

MEASURED = """
import sys
from intarsia.__main__ import main
told = sys.argv.pop(1)
try:
    main()
finally:
    peak = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM"))
    open(told, "w").write(peak)
"""

CASES = {
    "small": "grow sample:tiles -m repeat --size 60 -o o.png",
    "large": "grow sample:tiles -m repeat --size 3000 -o o.png",
    "float": "grow sample:stones -m random-tiling --size 1400 --feather 6 --depth float -o o.exr",
    "levelled": "grow sample:stones -m random-tiling --size 1400 --even-tone 32 -o o.png",
    "woven": "weave sample:tiles -m repeat --size 3000 --threads 7 -o o.zarr",
    "streamed": "weave sample:tiles -m repeat --size 3000 --threads 2 -o o.tif",
    "held": "weave sample:tiles -m repeat --size 4000 --threads 2 -o o.png",
}


@pytest.mark.parametrize("case", but_some(CASES, "large"))
def test_the_memory_told_is_within_a_quarter_of_the_peak(case: str, tmp_path: Path) -> None:
    words = [*CASES[case].split(), "--force"]
    around = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}

    def run(*more: str) -> str:
        command = [sys.executable, "-c", MEASURED, "peak.txt", *words, *more]
        return subprocess.run(command, cwd=tmp_path, env=around, capture_output=True, text=True, check=True).stdout

    run("-q")  # compiles what was not compiled yet, which takes memory of its own
    shutil.rmtree(tmp_path / "o.zarr", ignore_errors=True)  # or there is nothing left to weave
    run("-q")
    peak = int((tmp_path / "peak.txt").read_text()) / 1024
    told = json.loads(run("--dry-run", "--json"))["memory_mib"]
    assert 0.75 * peak <= told <= 1.25 * peak, f"{told} MiB told, {peak:.0f} MiB taken"
