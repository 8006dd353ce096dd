"""Kill commands at random moments, damage what they left as a loss of power does, and look whether anything is lost.

    python tests/hostile/kills.py --count 1000 --seed 1

Not part of the tests. Weaves (zarr, BigTIFF) are killed one to three times by KILL, TERM, INT or HUP, some of
them stopped and continued before; in four of ten cases pieces of an array are then cut, zeroed, turned over or
removed; then the same command must end in the bytes of one that nobody disturbed. A TIFF that has its name is
whole. `grow`, `extend` and `heal` are killed once: the output is whole or as it was before. After the next
start no file is left over. Every command runs in a forked child of a process that is warm, so that a kill costs a
fraction of a second. The last line is the tally; each failure is told in one line, with the number of its case:
``--only NUMBER`` repeats the choices, not the moments.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from random import Random

SIGNALS = (signal.SIGKILL,) * 4 + (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
STORES = {"zarr": "o.zarr", "tiff": "o.tif"}
WEAVE = ["-m", "repeat", "--size", "150x170", "--origin=-30,7", "--threads", "1", "-q"]
ONCE = {
    "grow": ["grow", "a.png", "-m", "image-quilting", "--patch", "12", "--size", "60"],
    "extend": ["extend", "a.png", "--right", "24"],
    "heal": ["heal", "a.png", "--mask", "holes.png"],
}
LIMIT = 600  # s: longer, and a command hangs


class Failure(Exception):
    """A promise that was not kept."""


def main(argv: Sequence[str] | None = None) -> int:
    """Kill so many times as ``--count`` says; return how many cases failed, at most 1."""
    parser = argparse.ArgumentParser(description="Kill commands, damage files, and look whether anything is lost.")
    parser.add_argument("--count", type=int, default=100, help="kills, in all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=int, help="only the case of this number")
    given = parser.parse_args(argv)
    tally: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="kills-") as name:
        killing = Killing(Path(name), tally)
        case = given.only or 0
        while tally["kills"] < given.count and (given.only is None or case == given.only):
            try:
                killing.case(Random(f"{given.seed} {case}"), case)
            except Failure as e:
                tally["failures"] += 1
                print(f"case {case} of seed {given.seed}: {e}", flush=True)
            case += 1
            if case % 50 == 0:
                print(f"{case} cases: {told(tally)}", flush=True)
    print(f"{case} cases of seed {given.seed}: {told(tally)}", flush=True)
    return min(tally["failures"], 1)


def told(tally: Counter[str]) -> str:
    """The tally in a line."""
    return ", ".join(f"{tally[name]} {name}" for name in sorted(tally)) + f", {tally['failures']} failures"


class Killing:
    """What never changes between the cases: the inputs, the results of commands that nobody killed, and their times."""

    def __init__(self, root: Path, tally: Counter[str]) -> None:
        self.root, self.tally = root, tally
        self.inputs, self.tmp = root / "inputs", root / "tmp"
        for folder in (self.inputs, self.tmp):
            folder.mkdir()
        warm(self.inputs)
        tempfile.tempdir = str(self.tmp)
        self.whole: dict[str, dict[str, bytes]] = {}
        self.spent: dict[str, float] = {}  # s, of the whole command
        self.writes: dict[str, float] = {}  # s, of that from the first file on
        once = {name: [*words, "-o", "o.png", "-q"] for name, words in ONCE.items()}
        for name, words in ({name: self.weave(name) for name in STORES} | once).items():
            for _ in range(2):  # the first may have to compile
                work, begun = self.fresh(f"whole-{name}"), time.perf_counter()
                pid = self.start(words, work)
                code = self.first_file(pid, work)
                first = time.perf_counter()
                if (self.ended(pid) if code is None else code) != 0:
                    raise SystemExit(f"{name} does not work: {(self.root / 'told').read_text()}")
                end, self.whole[name] = time.perf_counter(), files_in(work)
                self.spent[name], self.writes[name] = end - begun, end - first

    def case(self, random: Random, number: int) -> None:
        """One case: a weave three times of five, else another command."""
        name = random.choice([*STORES, *STORES, *ONCE])
        work = self.fresh("case")
        self.weaves(random, name, work) if name in STORES else self.once(random, name, work)
        if left := os.listdir(self.tmp):
            raise Failure(f"{name}: {left} below TMPDIR after the next start")

    def weaves(self, random: Random, name: str, work: Path) -> None:
        """Kill a weave, damage it, and go on."""
        words, history, path = self.weave(name), list[str](), work / STORES[name]
        for _ in range(random.choice((1, 1, 2, 3))):
            history.append(self.killed(random, name, words, work))
            left = {n: data for n, data in files_in(work).items() if not n.startswith(".intarsia-")}
            if name != "zarr" and path.exists() and left != self.whole[name]:
                raise Failure(f"{name}: it has its name and is not whole: {history}")
            if name == "zarr" and random.random() < 0.4 and path.exists():
                history.append(damage(random, path))
                self.tally["losses of power"] += 1
        status = self.ended(self.start(words, work))
        if status != 0:
            raise Failure(f"{name}: ended with {status}, {(self.root / 'told').read_text()!r}: {history}")
        if (found := files_in(work)) != self.whole[name]:
            differing = sorted(n for n in {*found, *self.whole[name]} if found.get(n) != self.whole[name].get(n))
            raise Failure(f"{name}: other bytes in {differing[:5]}: {history}")

    def once(self, random: Random, name: str, work: Path) -> None:
        """Kill a command that makes one file; what was there before stays, or the new one is whole."""
        old, words = b"old" * 99, [*ONCE[name], "-o", "o.png", "--threads", "1", "-q"]
        if random.random() < 0.5:
            (work / "o.png").write_bytes(old)
        words, whole = [*words, "--force"], self.whole[name]
        before = files_in(work)
        history = self.killed(random, name, words, work)
        after = {n: data for n, data in files_in(work).items() if not n.startswith(".intarsia-")}
        if after not in (before, whole):
            raise Failure(f"{name}: neither what was there nor what was to come: {sorted(after)}: {history}")
        status = self.ended(self.start(words, work))
        if status != 0 or files_in(work) != whole:
            raise Failure(f"{name}: ended with {status}, {sorted(files_in(work))}: {history}")

    def killed(self, random: Random, name: str, words: list[str], work: Path) -> str:
        """Start a command and kill it, perhaps after a pause; say how."""
        number, late, pause = random.choice(SIGNALS), random.random() < 0.7, random.random() < 0.16
        spent = self.writes if late else self.spent
        moment = random.random() * spent[name]
        pid = self.start(words, work)
        status = self.first_file(pid, work) if late else None  # most of the time goes by before anything is written
        if status is not None:
            return "nothing, it was done"
        time.sleep(moment / 2 if pause else moment)
        if pause:
            os.kill(pid, signal.SIGSTOP)
            time.sleep(0.01)
            os.kill(pid, signal.SIGCONT)
            time.sleep(moment / 2)
            self.tally["stopped and continued"] += 1
        os.kill(pid, number)
        status, word = self.ended(pid), signal.Signals(number).name
        self.tally["kills"] += 1
        self.tally[word] += 1
        how = "after it was done" if status == 0 else "at work"
        self.tally[how] += 1
        spent[name] = max(spent[name] * (0.8 if status == 0 else 1.1), 0.001)  # the machine's load changes
        if status not in (0, 130, -number):
            raise Failure(f"{name}: {word} ended with {status}, {(self.root / 'told').read_text()!r}")
        if status == -number and number != signal.SIGKILL:
            self.tally[f"ended by {word} itself"] += 1
        return f"{word} after {moment:.3f} s{' of writing' * late}, status {status}"

    def first_file(self, pid: int, work: Path) -> int | None:
        """Wait until a command has made or changed a file; its exit code where it ended before."""
        before = listed(work)
        while listed(work) == before:
            found, status = os.waitpid(pid, os.WNOHANG)
            if found:
                return os.waitstatus_to_exitcode(status)
            time.sleep(0.001)
        return None

    def start(self, words: list[str], work: Path) -> int:
        """Begin a command in a forked child."""
        pid = os.fork()
        if pid:
            return pid
        code = 99
        signal.alarm(LIMIT)
        try:
            for number in (signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, signal.SIG_DFL)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            out = os.open(self.root / "told", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            for standard in (1, 2):
                os.dup2(out, standard)
            os.chdir(work)
            from intarsia.cli import cli

            cli.main(words)
        except SystemExit as e:
            code = e.code if isinstance(e.code, int) else 98
        except KeyboardInterrupt:  # before the command minds signals itself
            code = 130
        finally:
            os._exit(code)

    def ended(self, pid: int) -> int:
        """Wait for the end of a command: its exit code, or the signal, negative."""
        status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        if status == -signal.SIGALRM:
            raise Failure("a command hangs")
        return status

    def fresh(self, name: str) -> Path:
        """A new folder with the inputs in it."""
        work = self.root / name
        shutil.rmtree(work, ignore_errors=True)
        shutil.copytree(self.inputs, work)
        return work

    def weave(self, name: str) -> list[str]:
        """The command that weaves such a store."""
        return ["weave", "a.png", "-o", STORES[name], *WEAVE, "--chunk", "32", *([] if name == "zarr" else ["--force"])]


def warm(folder: Path) -> None:
    """Make the inputs, load what every command needs, and cut weaves into small pieces."""
    import numpy as np
    import tifffile  # noqa: F401
    import zarr  # noqa: F401

    import intarsia as ia
    from intarsia import files
    from intarsia.giant import exports, zarrays
    from intarsia.testing import texture

    zarrays.SIDE = exports.SIDE = 32
    exports.AREA = 32 * 64
    files.write(folder / "a.png", texture(48, 48, 3, 1))
    holes = np.zeros((48, 48), np.uint8)
    holes[20:28, 18:30] = 255
    files.write(folder / "holes.png", holes)
    run = ia.Run(1)  # threads do not outlive a fork
    ia.synthesize(files.read(folder / "a.png"), 60, ia.ImageQuilting(patch=12), run=run)


def files_in(folder: Path) -> dict[str, bytes]:
    """Every file below a folder, by its name."""
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def listed(folder: Path) -> list[tuple[str, int]]:
    """Names and times of what lies in a folder and in a store in it."""
    found = list[tuple[str, int]]()
    for at in (folder, folder / "o", folder / "o.zarr"):
        for name in os.listdir(at) if at.is_dir() else ():
            with suppress(FileNotFoundError):  # temporary files go again
                found.append((name, (at / name).lstat().st_mtime_ns))
    return sorted(found)


def damage(random: Random, store: Path) -> str:
    """Do to an array what a loss of power may do to its pieces."""
    pieces = sorted(p for p in store.glob("c/*/*/0"))
    return "; ".join(damaged(random, p) for p in random.sample(pieces, min(len(pieces), random.randrange(4)))) or "none"


def damaged(random: Random, path: Path) -> str:
    """Damage a file."""
    data, how = path.read_bytes(), random.choice(("empty", "cut", "zeros", "flip", "gone"))
    at = random.randrange(len(data) + 1)
    if how == "gone":
        path.unlink()
    else:
        path.write_bytes({
            "empty": b"",
            "cut": data[:at],
            "zeros": data[:at] + bytes(len(data) - at),
            "flip": data[:at] + bytes(255 ^ b for b in data[at : at + 1]) + data[at + 1 :],
        }[how])  # fmt: skip
    return f"{path.name} {how} at {at} of {len(data)}"


if __name__ == "__main__":
    sys.exit(main())
