"""Kernels are compiled once, told of, kept on disk, and divide by nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import numpy as np
from intarsia import kernels
from intarsia.kernels import shortest_paths as paths
kernels.on_first_compilation(lambda: print("compiled"))
cost = np.array([[3, 1, 2], [4, 9, 1], [1, 1, 7]])
print(paths.cheapest(cost).tolist(), paths.accumulate(cost, 0)[2].tolist())
print(sum(sum(k.stats.cache_hits.values()) for k in (paths.cheapest, paths.accumulate)))
"""
RIGHT = "[1, 2, 1] [6, 3, 9]"


def start(home: Path) -> subprocess.Popen[str]:
    around, command = {**os.environ, "INTARSIA_CACHE": str(home)}, [sys.executable, "-c", SCRIPT]
    return subprocess.Popen(command, env=around, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process: subprocess.Popen[str]) -> tuple[list[str], str]:
    told, warned = process.communicate(timeout=300)
    assert process.returncode == 0, warned
    return told.splitlines(), warned


def test_kernels_are_compiled_once_and_told_of_also_by_two_processes_at_once(tmp_path: Path) -> None:
    both = [start(tmp_path) for _ in range(2)]
    assert [ended(one)[0][:2] for one in both] == [["compiled", RIGHT]] * 2
    assert ended(start(tmp_path)) == ([RIGHT, "2"], "")


def test_where_nothing_can_be_kept_kernels_are_compiled_and_one_line_says_so(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    told, warned = ended(start(tmp_path / "file"))
    assert told == ["compiled", RIGHT, "0"]
    assert warned.count("compiled kernels are not kept in") == 1


@pytest.mark.long
def test_no_kernel_divides_by_0_in_what_warms_up(tmp_path: Path) -> None:
    script = """if True:
    import sys
    from intarsia.kernels import jit
    jit.OPTIONS["error_model"] = "python"  # which raises where one does
    from intarsia.__main__ import main
    sys.argv = ["intarsia", "warm-up", "--quiet"]
    main()
    """
    around = {**os.environ, "INTARSIA_CACHE": str(tmp_path)}
    subprocess.run([sys.executable, "-c", script], env=around, check=True)
    assert any(tmp_path.rglob("*.nbc"))
