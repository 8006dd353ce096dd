"""Break the package line by line, and demand that the test which claims the rule fails.

    python tests/mutants.py              every row of mutants.toml
    python tests/mutants.py axes cuts    the rows whose file or rule holds one of these words

A row names a file of the package, a text that occurs in it exactly once, what to put in its place, the tests that must
fail then, and the rule in words. Rows are tried in copies of the package, one for each worker, which are kept between
runs: a file is written only where it changed, so that compiled kernels stay valid, and is put back with its old time.
A changed kernel is compiled into a cache of its own. Exit code 1 where a mutation survives, or breaks more than a test.
"""

from __future__ import annotations

import os
import queue
import shutil
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent
SOURCE = ROOT / "src" / "intarsia"
COPIES = ROOT / ".mutants"
LIMIT = 900  # s: a test that takes longer has noticed something, too
CAUGHT, SURVIVED, BROKEN = "caught", "SURVIVED", "BROKEN"


@dataclass(frozen=True)
class Mutant:
    """One mutation: `old` in `file` becomes `new`, and each of `tests` alone must fail."""

    rule: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    @property
    def name(self) -> str:
        """How it is told of in a table."""
        return f"{self.file}: {self.rule}"


def mutants() -> list[Mutant]:
    """The rows of mutants.toml."""
    with (TESTS / "mutants.toml").open("rb") as file:
        rows = tomllib.load(file)["mutant"]
    return [Mutant(r["rule"], r["file"], r["old"], r["new"], tuple(r["tests"])) for r in rows]


@dataclass(frozen=True)
class Copy:
    """A copy of the package that mutations are tried in."""

    home: Path

    @classmethod
    def of(cls, number: int) -> Copy:
        """Make the copy equal to the package, writing only what differs."""
        copy = cls(COPIES / str(number))
        package = copy.home / "intarsia"
        package.mkdir(parents=True, exist_ok=True)
        wanted = {p.relative_to(SOURCE) for p in SOURCE.rglob("*") if p.is_file() and "__pycache__" not in p.parts}
        for path in [p for p in package.rglob("*") if p.is_file()]:
            if path.relative_to(package) not in wanted:
                path.unlink()
        for name in sorted(wanted):
            here, there = SOURCE / name, package / name
            if not there.is_file() or there.read_bytes() != here.read_bytes():
                there.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(here, there)
        return copy

    def run(self, tests: Iterable[str], cache: str, limit: int | None = None) -> subprocess.CompletedProcess[str]:
        """Run tests on the copy; TimeoutExpired where they do not end within a limit of s."""
        environment = {
            **os.environ, "PYTHONPATH": str(self.home), "INTARSIA_CACHE": str(self.home / cache),
            "PYTHONDONTWRITEBYTECODE": "1", "OPENBLAS_NUM_THREADS": "1",
        }  # fmt: skip
        options = ("-x", "-q", "--no-header", "-p", "no:cacheprovider", "-p", "no:xdist", "--timeout=0")
        return subprocess.run(
            [sys.executable, "-m", "pytest", *options, *(str(TESTS / t) for t in tests)],
            capture_output=True, text=True, env=environment, cwd=ROOT, timeout=limit,
        )  # fmt: skip

    def tried(self, mutant: Mutant) -> tuple[str, str]:
        """What became of a mutation, and what its tests said if it was not caught."""
        path = self.home / "intarsia" / mutant.file
        text, times = path.read_text(encoding="utf-8"), path.stat()
        try:
            path.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
            for test in mutant.tests:
                done = self.run([test], "cache-mutants" if "kernels" in mutant.file else "cache", LIMIT)
                if done.returncode != 1:  # 1: a test failed; anything else: no test was there, or none could run
                    return SURVIVED if done.returncode == 0 else BROKEN, f"{test}\n{done.stdout[-2000:]}{done.stderr}"
        except subprocess.TimeoutExpired:
            return CAUGHT, ""
        finally:
            path.write_text(text, encoding="utf-8")
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        return CAUGHT, ""


def main(words: list[str], workers: int) -> int:
    """Try the rows that hold one of the words, print a table, and return the exit code."""
    rows = [m for m in mutants() if not words or any(word in m.name for word in words)]
    copies = [Copy.of(number) for number in range(max(1, min(workers, len(rows))))]
    begun = time.monotonic()
    tests = dict.fromkeys(test for mutant in rows for test in mutant.tests)
    whole = copies[0].run(tests, "cache")
    if whole.returncode:
        print(f"Without any mutation the tests must pass:\n{whole.stdout[-4000:]}{whole.stderr}")
        return 1
    print(f"{len(tests)} tests pass on the package as it is, {time.monotonic() - begun:.0f} s", flush=True)
    free: queue.Queue[Copy] = queue.Queue()
    for copy in copies:
        free.put(copy)

    def tried(mutant: Mutant) -> tuple[str, str]:
        copy, start = free.get(), time.monotonic()
        try:
            found, said = copy.tried(mutant)
        finally:
            free.put(copy)
        print(f"{found:8} {time.monotonic() - start:5.0f} s  {mutant.name}\n{said}", end="", flush=True)
        return found, said

    with ThreadPoolExecutor(len(copies)) as pool:
        found = [state for state, _ in pool.map(tried, rows)]
    caught = found.count(CAUGHT)
    print(f"{caught} of {len(rows)} mutations caught, {time.monotonic() - begun:.0f} s")
    return 0 if rows and caught == len(rows) else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:], int(os.environ.get("WORKERS", "1"))))
