"""Kill a weave again and again, call it again, and compare the files with those of one that nobody killed.

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
from intarsia.foundation.run import below, draw

SIZE, FORMATS = (150, 170), ("zarr", "tiff")


def woven(path: Path, how: str) -> None:
    """Weave a small picture in many small cells; what does not go on begins anew."""
    from intarsia.giant import exports, zarrays

    zarrays.SIDE = exports.SIDE = 32
    exports.AREA = 32 * 64
    more: dict = {"chunk": 16} if how == "zarr" else {"tile": 16, "force": True}
    getattr(small(), f"to_{how}")(path, SIZE, origin=(-30, 2**31 - 80), run=ia.Run(1), **more)


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
    import tifffile  # noqa: F401  here, so that no child has to
    import zarr  # noqa: F401

    small()[0:20, 0:20]  # loads the kernels that all share; draws in this thread
    whole, spent, killed = {}, {}, 0
    for how in FORMATS:
        path, begun = folder / f"whole-{how}", time.perf_counter()
        assert os.waitpid(forked(path, how), 0)[1] == 0
        spent[how] = time.perf_counter() - begun
        whole[how] = files_below(path)
    for n in range(rounds):
        how = FORMATS[n % len(FORMATS)]
        (folder / str(n)).mkdir()
        path, before = folder / str(n) / "killed", killed
        for again in range(3):
            pid = forked(path, how)
            time.sleep(spent[how] * below(1000, draw(n, 77, again)) / 1000 / (again + 1))
            os.kill(pid, signal.SIGKILL)
            killed += os.WIFSIGNALED(os.waitpid(pid, 0)[1])
            if how != "zarr" and path.exists():
                assert files_below(path) == whole[how], n  # what bears its name is whole
        assert killed > before or files_below(path), n
        assert os.waitpid(forked(path, how), 0)[1] == 0, n
        assert files_below(path) == whole[how], n
        assert list(path.parent.iterdir()) == [path], n
    print(killed)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
