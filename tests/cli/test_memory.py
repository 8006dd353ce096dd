"""Little memory: a work that does not fit is refused before it begins, and what is told is near what is taken."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from intarsia import disk
from intarsia.foundation import ResourceError

linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="address spaces and /proc as of Linux")

LIMITED = """
import resource, sys
limit = int(sys.argv.pop(1)) << 10
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
from intarsia.__main__ import main
main()
"""


def limited(limit: int, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a command whose address space is limited to so many KiB, as `ulimit -v` does."""
    around = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    line = [sys.executable, "-c", LIMITED, str(limit), *words]
    return subprocess.run(line, env=around, capture_output=True, text=True, timeout=90, check=False)


GROW = ("grow", "sample:tiles", "-m", "repeat", "--size")


@linux
@pytest.mark.parametrize("limit", [250_000, 400_000, 500_000, 700_000])
def test_an_address_space_in_which_libraries_hang_or_crash_is_refused_at_once(tmp_path: Path, limit: int) -> None:
    done = limited(limit, *GROW, "9000", "-o", str(tmp_path / "o.png"))
    assert done.returncode == 1, done.stderr
    (line,) = done.stderr.splitlines()
    assert f"address space is limited to {limit >> 10} MiB" in line
    assert not list(tmp_path.iterdir())


@linux
def test_in_a_larger_one_small_work_is_done_and_large_work_refused_before_it_begins(tmp_path: Path) -> None:
    done = limited(1_000_000, *GROW, "60", "-o", str(tmp_path / "o.png"))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "o.png").is_file()
    done = limited(1_000_000, *GROW, "16384", "-o", str(tmp_path / "p.png"))
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert all(words in line for words in ("16384x16384 px", "address space", "--size"))
    assert not (tmp_path / "p.png").exists()


AGAIN = """
import resource
from intarsia.disk import prepare_memory
prepare_memory()
import numpy as np
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
def work():
    parts = [np.ones(1 << 17) for _ in range(30)]
work()
before = faults()
for _ in range(20):
    work()
print(faults() - before)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="options of glibc's heap")
def test_arrays_are_made_of_what_others_left() -> None:
    """Each of 600 arrays has 256 pages, which the system would clear for it."""
    done = subprocess.run([sys.executable, "-c", AGAIN], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 600 * 256 // 10


@linux
def test_help_needs_no_room() -> None:
    done = limited(200_000, "grow", "--help")
    assert done.returncode == 0, done.stderr


def test_what_is_surely_too_much_is_refused_and_what_may_fit_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk, "_limits", lambda: iter([(1 << 40, "one has"), (1000 << 20, "another leaves")]))
    disk.check_fits(1200 << 20, "a work")
    with pytest.raises(ResourceError, match="a work takes about 1300 MiB of memory, and another leaves 1000 MiB"):
        disk.check_fits(1300 << 20, "a work")


def test_the_limits_of_control_groups_are_found_in_both_versions_and_in_every_group_above(tmp_path: Path) -> None:
    own, root = tmp_path / "cgroup", tmp_path / "root"
    own.write_text("7:blkio:/\n4:memory:/a/b\n0::/c/d\n")
    old, new = root / "memory" / "a", root / "c" / "d"
    for folder, values in (
        (old, {"limit_in_bytes": "900", "usage_in_bytes": "500", "stat": "cache 1\ntotal_inactive_file 100\n"}),
        (new, {"max": "max", "current": "5", "stat": "inactive_file 1\n"}),
        (new.parent, {"max": "700", "current": "300", "stat": "inactive_file 50\n"}),
    ):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in values.items():
            (folder / f"memory.{name}").write_text(text)
    assert list(disk._groups(str(root), str(own))) == [(900, 400), (700, 250)]


SEEING = """
import os, sys
class Seen:
    def find_spec(name, path=None, target=None):
        if name == "numpy":
            print("threads", os.environ.get("OPENBLAS_NUM_THREADS"), file=sys.stderr)
            sys.meta_path.remove(Seen)
sys.meta_path.insert(0, Seen)
from intarsia.__main__ import main
main()
"""


@pytest.mark.parametrize(("given", "kept"), [(None, "1"), ("3", "3")])
def test_linear_algebra_begins_with_one_thread_unless_the_user_says_another(given: str | None, kept: str) -> None:
    around = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    around |= {"OPENBLAS_NUM_THREADS": given} if given else {}
    words = [sys.executable, "-c", SEEING, "grow", "sample:tiles", "--size", "80", "--dry-run"]
    done = subprocess.run(words, env=around, capture_output=True, text=True, timeout=90, check=False)
    assert done.returncode == 0, done.stderr
    assert f"threads {kept}\n" in done.stderr
