"""Kernels with a numba whose inside is not known: what is public does the same, kept and checked all the same."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
from hostile import caches

SCRIPT = """
import sys, numpy as np, numba
if sys.argv[1] == "newer":
    numba.__version__ = "1234.5"
elif sys.argv[1] == "changed":
    import numba.core.codegen
    del numba.core.codegen.JITCodeLibrary
from intarsia import kernels
from intarsia.kernels import shortest_paths as paths
kernels.on_first_compilation(lambda: print("compiled"))
cost = np.array([[3, 1, 2], [4, 9, 1], [1, 1, 7]])
print(paths.cheapest(cost).tolist(), paths.accumulate(cost, 0)[2].tolist())
hits = sum(sum(k.stats.cache_hits.values()) for k in (paths.cheapest, paths.accumulate))
print(hits, type(paths.cheapest).__module__)
"""
RIGHT = "[1, 2, 1] [6, 3, 9]"


def start(kind: str, home: Path) -> subprocess.Popen[str]:
    around = {**os.environ, "INTARSIA_CACHE": str(home)}
    command = [sys.executable, "-c", SCRIPT, kind]
    return subprocess.Popen(command, env=around, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process: subprocess.Popen[str]) -> tuple[list[str], str]:
    told, warned = process.communicate(timeout=300)
    assert process.returncode == 0, warned
    return told.splitlines(), warned


@pytest.mark.parametrize("kind", ["known", "newer", "changed"])
def test_whatever_numba_has_inside_kernels_are_right_compiled_once_and_told_of(kind: str, tmp_path: Path) -> None:
    by = "intarsia.kernels.compiling" if kind == "known" else "numba.core.registry"
    assert ended(start(kind, tmp_path)) == (["compiled", RIGHT, f"0 {by}"], "")
    assert ended(start(kind, tmp_path)) == ([RIGHT, f"2 {by}"], "")


def test_what_another_numba_kept_is_made_anew_with_one_line_where_it_is_damaged(tmp_path: Path) -> None:
    ended(start("newer", tmp_path))
    kept = sorted(tmp_path.rglob("*.nb?"))
    assert len(kept) == 7  # index and code of three kernels, of one for a written number, too
    kinds = ["cut", "flipped bit", "vast", "folder", "link", "fifo" if hasattr(os, "mkfifo") else "empty"]
    for kind, path in zip(kinds, kept, strict=False):
        caches.ON_FILES[kind](path, random.Random(5))
    told, warned = ended(start("newer", tmp_path))
    assert told[:2] == ["compiled", RIGHT]
    assert warned.count("was damaged; it is compiled anew") == 1
    assert ended(start("newer", tmp_path))[0][1].startswith("2 ")


def test_what_no_list_names_is_not_loaded(tmp_path: Path) -> None:
    ended(start("newer", tmp_path))
    (listed,) = tmp_path.rglob("*.list")
    listed.unlink()
    told, warned = ended(start("newer", tmp_path))
    assert (told[0], warned) == ("compiled", "")


def test_two_processes_that_compile_at_once_leave_what_can_be_used(tmp_path: Path) -> None:
    both = [start("newer", tmp_path) for _ in range(2)]
    assert [ended(one)[0][1] for one in both] == [RIGHT] * 2
    ended(start("newer", tmp_path))
    assert ended(start("newer", tmp_path))[0][1].startswith("2 ")
