"""Damage the folder of compiled kernels at random: every command must still make its picture, with the right bytes.

    python tests/hostile/caches.py --count 500 --seed 1

Each case works on a copy of a good cache, in a process of its own, forked from one that has imported the libraries and
has run no kernel yet. A case fails if the command does not end well, if its picture differs, if more than one line was
said, or if a pickle that was planted was opened.
"""

from __future__ import annotations

import argparse
import os
import pickle
import random
import shutil
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path

WORDS = ("grow", "sample:tiles", "-m", "repeat", "--size", "60", "--force")
COMMANDS = (*[WORDS] * 7, (*WORDS, "--feather", "2"))
LIMIT = 120  # seconds of a case, compiling all anew on a busy machine


class Planted:
    """Whoever opens the pickle of this makes a folder."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str]]:
        return os.mkdir, (str(self.path),)


def entries(home: Path) -> list[Path]:
    """All files of a cache, in order."""
    return sorted(p for p in home.rglob("*") if p.is_file())


def _flip(path: Path, r: random.Random, most: int) -> None:
    data = bytearray(path.read_bytes())
    data[r.randrange(min(most, len(data)))] ^= 1 << r.randrange(8)
    path.write_bytes(data)


def _instead(path: Path, make: Callable[[Path], object]) -> None:
    path.unlink()
    make(path)


def _swap(path: Path, r: random.Random) -> None:
    other = r.choice(entries(path.parent))
    mine, its = path.read_bytes(), other.read_bytes()
    path.write_bytes(its)
    other.write_bytes(mine)


def _plant(path: Path, r: random.Random) -> None:
    data, trap = path.read_bytes(), pickle.dumps(Planted(path.parents[1] / "sprung"))
    path.write_bytes(r.choice((b"", data[:56])) + trap)


ON_FILES: dict[str, Callable[[Path, random.Random], object]] = {
    "empty": lambda p, r: p.write_bytes(b""),
    "cut": lambda p, r: os.truncate(p, r.randrange(p.stat().st_size)),
    "zeros": lambda p, r: p.write_bytes(bytes(p.stat().st_size)),
    "random": lambda p, r: p.write_bytes(r.randbytes(p.stat().st_size)),
    "flipped bit": lambda p, r: _flip(p, r, 1 << 30),
    "header": lambda p, r: _flip(p, r, 56),
    "longer": lambda p, r: p.write_bytes(p.read_bytes() + r.randbytes(r.randrange(1, 999))),
    "vast": lambda p, r: os.truncate(p, r.choice((1 << 20, 1 << 33))),
    "swapped": _swap,
    "planted pickle": _plant,
    "gone": lambda p, r: p.unlink(),
    "folder": lambda p, r: _instead(p, lambda q: (q / "sub").mkdir(parents=True)),
    "fifo": lambda p, r: _instead(p, os.mkfifo),
    "link": lambda p, r: _instead(p, lambda q: q.symlink_to(r.choice((q.name, "nowhere", "/dev/zero")))),
    "writable by others": lambda p, r: p.chmod(0o666),
    "unreadable": lambda p, r: p.chmod(0),
}
"""What is done to single files."""


def _as_file(folder: Path) -> None:
    shutil.rmtree(folder)
    folder.write_bytes(b"x")


def _as_link(folder: Path) -> None:
    folder.rename(folder.with_name("moved"))
    folder.symlink_to("moved")


def _litter(folder: Path) -> None:
    for name in ("x.kernel", "x.kernel.0123456789abcdef", "y.nbi", "kernels-" + "0" * 16):
        (folder / name).write_bytes(b"litter")


ON_FOLDERS: dict[str, Callable[[Path], object]] = {
    "folder is a file": _as_file,
    "folder is a link": _as_link,
    "folder is gone": shutil.rmtree,
    "folder is open to others": lambda f: f.chmod(0o777),
    "folder is read only": lambda f: f.chmod(0o500),
    "home is open to others": lambda f: f.parent.chmod(0o777),
    "home is a file": lambda f: _as_file(f.parent),
    "litter": _litter,
}
"""What is done to the folder of the kernels."""


def damage(home: Path, r: random.Random, most: int) -> str:
    """Damage a cache at random, at most so many entries where it is not the whole folder; return what was done."""
    if most > 3 and r.random() < 0.2:
        kind = r.choice(sorted(ON_FOLDERS))
        ON_FOLDERS[kind](next(p for p in home.iterdir() if p.is_dir()))
        return kind
    files = entries(home)
    kind = r.choice(sorted(ON_FILES))
    for path in r.sample(files, min(len(files), r.choice((1, 1, 2, most)))):
        if path.is_file() and not path.is_symlink():
            ON_FILES[kind](path, r)
    return kind


def drawn(words: tuple[str, ...], home: Path, out: Path, said: Path) -> bool:
    """Run a command with a cache, in a fork of this process; tell whether it ended well."""
    child = os.fork()
    if not child:
        code = 70
        signal.alarm(LIMIT)
        try:
            os.environ["INTARSIA_CACHE"] = str(home)
            os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), 2)
            from intarsia.cli import cli

            try:
                cli.main([*words, "-o", str(out)], prog_name="intarsia")
                code = 0
            except SystemExit as e:
                code = e.code if isinstance(e.code, int) else int(e.code is not None)
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def fault(words: tuple[str, ...], home: Path, right: bytes, folder: Path) -> str | None:
    """Say what is wrong with a command that runs with a damaged cache, or None."""
    out, said = folder / "out.png", folder / "said.txt"
    out.unlink(missing_ok=True)
    ended = drawn(words, home, out, said)
    lines = said.read_text(errors="replace").splitlines()
    if not ended:
        return f"it did not end well: {lines[-1:]}"
    if out.read_bytes() != right:
        return "another picture"
    if len([w for w in lines if not w.startswith(str(out))]) > 1:
        return f"more than one line: {lines}"
    if list(home.parent.rglob("sprung")):
        return "a planted pickle was opened"
    return None


def prepare() -> None:
    """Import what a command needs, and run no kernel."""
    import warnings

    from numba.core.registry import cpu_target

    from intarsia import cli  # noqa: F401
    from intarsia.cli import verbs  # noqa: F401
    from intarsia.files import sample

    warnings.simplefilter("ignore")  # as the command does
    sample("tiles")
    cpu_target.typing_context.refresh()  # most of what a first call costs
    cpu_target.target_context.refresh()


def main(argv: list[str] | None = None) -> int:
    """Run the campaign; print what failed and a table of what was tried."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--plain", action="store_true", help="only the command that needs a single kernel")
    given = parser.parse_args(argv)
    commands = COMMANDS[:1] if given.plain else COMMANDS
    prepare()
    tried: Counter[str] = Counter()
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        right, good = {}, folder / "good"
        for words in dict.fromkeys(commands):
            assert drawn(words, good, folder / "right.png", folder / "said.txt"), (folder / "said.txt").read_text()
            right[words] = (folder / "right.png").read_bytes()
        for number in range(given.count):
            r = random.Random(given.seed * 1_000_003 + number)
            place = folder / "case"
            shutil.copytree(good, place / "cache")
            words = r.choice(commands)
            kind = damage(place / "cache", r, 99 if words == WORDS else 3)  # where little is compiled anew
            tried[kind] += 1
            for time_ in ("first", "second"):  # the second finds a cache that is whole again, or says so once more
                found = fault(words, place / "cache", right[words], folder)
                if found is not None:
                    failed += 1
                    print(f"seed {given.seed}, case {number}, {kind}, {' '.join(words)}, {time_} run: {found}")
                    break
            shutil.rmtree(place)
    for kind, count in sorted(tried.items()):
        print(f"{count:6} {kind}")
    print(f"{given.count} damaged caches, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
