"""Break the package line by line, and demand that the test which claims the rule fails.

    python tests/mutants.py              every row of mutants.toml
    python tests/mutants.py axes cuts    the rows whose file or rule holds one of these words
    python tests/mutants.py --share 10   a tenth of the rows, drawn by the commit, or by --seed WORD

A row names a file of the package, a text that occurs in it exactly once, what to put in its place, the tests that must
fail then, and the rule in words. Rows are tried in copies of the package, one for each worker, which are kept between
runs: a file is written only where it changed, so that compiled kernels stay valid, and is put back with its old time.
Kernels as they are come from the user's cache, changed ones from a cache of their own. Exit code 1 where a mutation
survives, or breaks more than a test.
"""

from __future__ import annotations

import argparse
import os
import queue
import random
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

    def run(
        self, tests: Iterable[str], kernels: bool = False, limit: int | None = None
    ) -> subprocess.CompletedProcess[str]:
        """Run tests on the copy, whose `kernels` may be changed; TimeoutExpired where they take more than `limit` s."""
        environment = os.environ | {
            "PYTHONPATH": str(self.home), "PYTHONDONTWRITEBYTECODE": "1", "OPENBLAS_NUM_THREADS": "1",
        } | ({"INTARSIA_CACHE": str(self.home / "cache")} if kernels else {})  # fmt: skip
        options = ["-x", "-q", "--no-header", "-p", "no:cacheprovider", "-p", "no:xdist", "--timeout=0"]
        return subprocess.run(
            [sys.executable, "-m", "pytest", *options, "-m", "not long", *(str(TESTS / t) for t in tests)],
            capture_output=True, text=True, env=environment, cwd=ROOT, timeout=limit,
        )  # fmt: skip

    def tried(self, mutant: Mutant) -> tuple[str, str]:
        """What became of a mutation, and what its tests said if it was not caught."""
        path = self.home / "intarsia" / mutant.file
        text, times = path.read_text(encoding="utf-8"), path.stat()
        try:
            path.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
            for test in mutant.tests:
                done = self.run([test], "kernels" in mutant.file, LIMIT)
                if done.returncode != 1:  # 1: a test failed; anything else: no test was there, or none could run
                    return SURVIVED if done.returncode == 0 else BROKEN, f"{test}\n{done.stdout[-2000:]}{done.stderr}"
        except subprocess.TimeoutExpired:
            return CAUGHT, ""
        finally:
            path.write_text(text, encoding="utf-8")
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        return CAUGHT, ""


def drawn(rows: list[Mutant], share: int, seed: str) -> list[Mutant]:
    """One of so many rows, rounded up, by a seed: the same for the same, and over many seeds each as often."""
    return random.Random(seed).sample(rows, -(-len(rows) // share))


def commit() -> str:
    """What stands for the code as it is; the day where there is no repository."""
    asked = ["git", "-C", str(ROOT), "rev-parse", "--short=12", "HEAD"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    return done.stdout.strip() or time.strftime("%Y-%m-%d")


def main(words: list[str], share: int, seed: str, workers: int) -> int:
    """Try the rows that hold one of the words, or a share of them, print a table, and return the exit code."""
    rows = [m for m in mutants() if not words or any(word in m.name for word in words)]
    if share > 1:
        listed, rows = len(rows), drawn(rows, share, seed)
        print(f"{len(rows)} of {listed} rows; again: python tests/mutants.py --share {share} --seed {seed}", flush=True)
    copies = [Copy.of(number) for number in range(max(1, min(workers, len(rows))))]
    begun = time.monotonic()
    tests = dict.fromkeys(test for mutant in rows for test in mutant.tests)
    whole = copies[0].run(tests)
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
    parser = argparse.ArgumentParser(description="Break the package line by line, and see that the tests notice.")
    parser.add_argument("words", nargs="*", help="rows whose file or rule holds one of these")
    parser.add_argument("--share", type=int, default=1, metavar="N", help="try one of N rows only")
    parser.add_argument("--seed", default="", help="which; by default the commit says")
    given = parser.parse_args()
    workers = int(os.environ.get("WORKERS", "1"))
    raise SystemExit(main(given.words, given.share, given.seed or commit(), workers))
