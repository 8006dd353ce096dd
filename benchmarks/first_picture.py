"""What people wait for before the first picture: whole processes, compiled kernels in a fresh folder and in a full one.

    python benchmarks/first_picture.py             prints the rows; `make bench` has them among the others
    python benchmarks/first_picture.py --child X   what the above runs in processes of its own
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import intarsia as ia
from bench import Result, child_cpu, pixels, table, unit_r
from intarsia.foundation import SAMPLES

REPEATS = 3
PYTHON = (sys.executable, "-m", "intarsia")
TWICE = ("--size", "512", "--force", "--quiet", "--threads", "1")
MODULES = "numpy, PIL.Image, numba, intarsia.cli.batch, intarsia.synthesis"  # of a command that grows


def run(words: tuple[str, ...], cache: Path) -> tuple[float, float]:
    """Run a command with a folder of compiled kernels; return its wall time and the CPU time of all its processes."""
    import resource

    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    around = {**os.environ, "INTARSIA_CACHE": str(cache)}
    subprocess.run(words, check=True, env=around, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.perf_counter() - began, cpu


def first_grow(name: str, cache: Path, folder: Path) -> list[Result]:
    """Grow what `intarsia grow` chooses for a sample: with an empty cache, then with the one that this has left."""
    source = folder / f"{name}.png"
    ia.write(str(source), pixels(name), force=True)
    words = (*PYTHON, "grow", str(source), "-o", str(folder / "out.png"), "--size", "512", "--force", "--quiet")
    r = unit_r()
    wall, cpu = run(words, cache)
    case = f"`intarsia grow`, {name}, 256x256 to 512x512, nothing compiled, wall"
    return [Result(case, wall, "s", 15, f"{cpu:.1f} s CPU, R {1000 * r:.0f} ms", wall)]


def every_grow(cache: Path, folder: Path) -> list[Result]:
    """Grow every sample, as most people do: no option, one thread, all compiled; then all of them as one batch."""
    rows, alone, files = [], 0.0, []
    for name in SAMPLES:
        source = folder / f"{name}.png"
        ia.write(str(source), pixels(name), force=True)
        r = unit_r()
        words = (*PYTHON, "grow", str(source), "-o", str(folder / "out.png"), *TWICE)
        cpu = statistics.median(run(words, cache)[1] for _ in range(REPEATS))
        case = f"`intarsia grow`, {name}, 256x256 to 512x512, all compiled, whole command, CPU"
        rows.append(Result(case, cpu / r, "R", 26, f"{cpu:.2f} s", cpu))
        alone, files = alone + cpu, [*files, str(source)]
    bare = child_cpu([sys.executable, "-c", f"import {MODULES}"], REPEATS)
    _, batch = run((*PYTHON, "grow", *files, "-o", str(folder / "batch-{stem}.png"), *TWICE), cache)
    share = (batch - bare) / (alone - bare * len(files))
    about = f"{batch:.1f} s for {len(files)}"
    return [*rows, Result("all of these in one command, to as many commands, without their start", share, "", 1, about)]


def warming(cache: Path) -> list[Result]:
    """Warm up an empty cache, then a full one."""
    r = unit_r()
    wall, cpu = run((*PYTHON, "warm-up", "--quiet"), cache)
    kept = [path.stat().st_size for path in cache.rglob("*.kernel")]
    _, again = run((*PYTHON, "warm-up", "--quiet"), cache)
    about = f"{cpu:.0f} s CPU, R {1000 * r:.0f} ms, {os.cpu_count()} cores"
    return [
        Result("`intarsia warm-up`, nothing compiled, wall", wall, "s", 40, about, wall),
        Result("what it keeps", float(len(kept)), "files", None, f"{sum(kept) / 1e6:.1f} MB"),
        Result("the same, all compiled, CPU", again, "s", None, "", again),
    ]


def starting(cache: Path) -> list[Result]:
    """What a command does before it works: imports, and loading what is compiled."""
    bare = child_cpu([sys.executable, "-c", "pass"])
    imports = child_cpu([sys.executable, "-c", f"import {MODULES}"]) - bare
    loading = statistics.median(child("loading", cache)["first"] for _ in range(REPEATS))
    return [
        Result("start and imports of a command that grows, CPU", imports, "s", 0.6),
        Result("the compiler made ready, and loading the kernels of the default path, CPU", loading, "s", None),
    ]


def child(name: str, cache: Path) -> dict[str, float]:
    """Run one of this file's children."""
    around = {**os.environ, "INTARSIA_CACHE": str(cache)}
    command = [sys.executable, __file__, "--child", name]
    done = subprocess.run(command, check=True, env=around, stdout=subprocess.PIPE, text=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def child_loading() -> dict[str, float]:
    """Grow a small texture twice with a full cache: what the first takes longer is loading, and more."""
    from intarsia.foundation.run import Run

    took = []
    for _ in range(2):
        began = time.process_time()
        ia.synthesize("sample:pebbles", 300, run=Run(1))
        took.append(time.process_time() - began)
    return {"first": took[0] - took[1]}


def measured() -> list[Result]:
    """Measure all rows; minutes, as everything is compiled three times."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = [row for sample in ("stones", "brick") for row in first_grow(sample, folder / sample, folder)]
        warm = warming(folder / "all")
        return every_grow(folder / "all", folder) + rows + warm + starting(folder / "all")


CHILDREN: dict[str, Any] = {"loading": child_loading}

if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        print(json.dumps(CHILDREN[sys.argv[2]]()))
    else:
        print(table(measured()))
