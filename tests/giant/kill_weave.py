"""Kill a weave again and again, resume it, and compare the files with those of one that nobody killed.

Run by ``test_weave_kills.py`` in a process of its own without threads, which forks for every weave: so a kill costs no
import, and fifty of them take seconds. Prints how many were killed before they were done.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

from giant.giants import files_below, small

import intarsia as ia
from intarsia.draws import below, draw

SIZE, FORMATS = (150, 170), ("zarr", "tiff", "tiles")


def woven(path: Path, how: str) -> None:
    """Weave a small picture in many small cells."""
    made, run = small(), ia.Run(1)
    if how == "zarr":
        from intarsia.giant import zarrays

        zarrays.SIDE = 32
        made.to_zarr(path, SIZE, origin=(-30, 2**31 - 80), chunk=16, run=run)
    elif how == "tiff":
        from intarsia.giant import bigtiff

        bigtiff.AREA = 32 * 64
        made.to_tiff(path, SIZE, origin=(-30, 2**31 - 80), tile=32, run=run)
    else:
        from intarsia.giant import deepzoom

        deepzoom.SIDE = 64
        made.to_tiles(path, SIZE, origin=(-30, 2**31 - 80), tile=32, run=run)


def forked(path: Path, how: str) -> int:
    """Weave in a process of its own."""
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            woven(path, how)
            code = 0
        finally:
            os._exit(code)
    return pid


def main(folder: Path, rounds: int) -> None:
    """Kill `rounds` weaves at random moments, one or more times each."""
    import zarr  # noqa: F401  here, so that no child has to

    small()[0:20, 0:20]  # loads the kernels that all share; draws in this thread
    whole, spent, killed = {}, {}, 0
    for how in FORMATS:
        path, begun = folder / f"whole-{how}", time.perf_counter()
        assert os.waitpid(forked(path, how), 0)[1] == 0
        spent[how] = time.perf_counter() - begun
        whole[how] = files_below(path)
    for n in range(rounds):
        how = FORMATS[n % len(FORMATS)]
        path, before = folder / f"killed-{n}", killed
        for again in range(3):
            pid = forked(path, how)
            time.sleep(spent[how] * below(1000, draw(n, 77, again)) / 1000 / (again + 1))
            os.kill(pid, signal.SIGKILL)
            killed += os.WIFSIGNALED(os.waitpid(pid, 0)[1])
        assert killed > before or files_below(path), n
        assert os.waitpid(forked(path, how), 0)[1] == 0, n
        assert files_below(path) == whole[how], n
    print(killed)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
