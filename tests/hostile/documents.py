"""Hostile maps, recipes and labels through ``render``, ``replay`` and ``paint``, in this process.

    python -m hostile.documents --count 300 --seed 0

A document fails that ends in a traceback, an internal error, another exit code than 0 to 3, more than one line or an
illegible one, over 2 s of CPU, or that leaves a file behind where the command failed. Failures are kept in ``fuzz/``.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import sys
import tempfile
import time
import warnings
import zipfile
from argparse import ArgumentParser
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

SLOW = 2.0
WORDS: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 2, 3.5, -0.0, float("nan"), float("inf"), 1 << 31, 1 << 63, 1 << 70, "", "q", "none",
    "\x1b]0;own\x07", "\u202e", "a" * 3000, "\ud800", [], {}, [[]], [1, 2], [-1, 1 << 40], {"a": {"b": []}},
    "sample:tiles", "../../etc/passwd", "__import__('os')", "alpha", "auto", "1/2", "#ff00ff",
)  # fmt: skip


def changed(value: Any, draw: Random, depth: int = 0) -> Any:
    """A document with something else somewhere in it."""
    if isinstance(value, dict) and value and (depth == 0 or draw.random() < 0.8):
        key, way = draw.choice(list(value)), draw.randrange(6)
        if way == 0:
            return {k: v for k, v in value.items() if k != key}
        if way == 1:
            return value | {str(draw.choice(WORDS)): draw.choice(WORDS)}
        return value | {key: changed(value[key], draw, depth + 1)}
    if isinstance(value, list) and value and draw.random() < 0.7:
        at = draw.randrange(len(value))
        return value[:at] + draw.choice(([], [changed(value[at], draw, depth + 1)], value * 3)) + value[at + 1 :]
    if isinstance(value, (int, float)) and draw.random() < 0.5:
        return draw.choice((value + 1, -value, value * 1000, value / 3, str(value)))
    return draw.choice(WORDS)


def recipe(sound: dict[str, Any], draw: Random) -> bytes:
    """A recipe with one to three changes, or with a few other bytes."""
    from hostile.mutants import mutant

    told: Any = sound
    for _ in range(draw.choice((1, 1, 2, 3))):
        told = changed(told, draw)
    data = json.dumps(told).encode()
    return mutant(data, draw) if draw.random() < 0.2 else data


def saved_map(sound: bytes, draw: Random) -> bytes:
    """A map with other words, other arrays, or other bytes."""
    import numpy as np

    from hostile.mutants import mutant

    if draw.random() < 0.3:
        return mutant(sound, draw)
    with np.load(io.BytesIO(sound)) as data:
        held: dict[str, Any] = {name: data[name] for name in data}
    if draw.random() < 0.5:
        about = changed(json.loads(bytes(held["about"])), draw)
        held["about"] = np.frombuffer(json.dumps(about).encode(), np.uint8)
    else:
        name = draw.choice([k for k in held if k != "about"])
        array = held[name].copy()
        how = draw.randrange(6)
        if how < 3:
            array.flat[draw.randrange(array.size)] = draw.choice((-1, 0, 7, 8, 200, 255, 99999)) & (
                0xFF if array.dtype == np.uint8 else -1)  # fmt: skip
        else:
            array = (array[1:], array.astype(np.float64), array.reshape(-1))[how - 3]
        held[name] = array
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **held)
    data_ = buffer.getvalue()
    return _lying(data_, draw) if draw.random() < 0.2 else data_


def _lying(data: bytes, draw: Random) -> bytes:
    """The same archive with another header in one of its arrays, such as one of 2**40 rows."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        victim = draw.choice(old.namelist())
        for name in old.namelist():
            body = old.read(name)
            if name == victim:
                side = draw.choice((0, 1 << 31, 1 << 40, 20000))
                head = f"{{'descr': '<i4', 'fortran_order': False, 'shape': ({side}, {side}, 2), }}".encode().ljust(117)
                body = b"\x93NUMPY\1\0" + (118).to_bytes(2, "little") + head + b"\n" + body[128:]
            new.writestr(name, body)
    return out.getvalue()


def labels(_: object, draw: Random) -> bytes:
    """A label picture of any kind: of other sizes, colours, depths and channels, or damaged."""
    import numpy as np
    from corpus import pillow

    from hostile.mutants import mended, mutant

    size = draw.choice(((20, 24), (20, 24), (20, 24), (1, 1), (24, 20), (40, 48)))
    shape = (*size, draw.choice((3, 4))) if draw.random() < 0.5 else size
    values = np.frombuffer(draw.randbytes(int(np.prod(shape))), np.uint8).reshape(shape)
    values = values // draw.choice((1, 64, 128, 255)) * draw.choice((1, 64, 127))
    data = pillow("png", values.astype(np.uint8))
    return mended(mutant(data, draw)) if draw.random() < 0.3 else data


def trial(words: list[str], place: Path, again: bool = False) -> str:
    """Run a command; return what is wrong with how it ended, "" for nothing."""
    from click.testing import CliRunner

    from intarsia.cli import cli

    before, began = sorted(os.listdir(place)), time.process_time()
    result = CliRunner().invoke(cli, words)
    took, after = time.process_time() - began, sorted(os.listdir(place))
    (place / "out.png").unlink(missing_ok=True)
    lines = [line for line in result.stderr.splitlines() if not line.startswith("intarsia: warning: ")]
    wrong = ""
    if "Traceback" in result.output or "internal error" in result.output or not 0 <= result.exit_code <= 3:
        wrong = f"exit {result.exit_code}: {result.output[:300]!r}"
    elif not all(line.isprintable() for line in result.output.splitlines()):
        wrong = f"illegible: {result.output[:300]!r}"
    elif result.exit_code and (len(lines) != 1 or after != before):
        wrong = f"{len(lines)} lines, files {sorted(set(after) - set(before))}"
    elif took > SLOW and not again:  # the first time, something may have been compiled
        return trial(words, place, True)
    elif took > SLOW:
        wrong = f"slow: {took:.1f} s"
    return wrong


def main(argv: list[str] | None = None) -> int:
    """Try `--count` documents of every kind; return how many failed."""
    parser = ArgumentParser(description=main.__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(argv)
    import roles

    from intarsia import files

    warnings.simplefilter("ignore")
    keep, here, failed = Path("fuzz").absolute(), os.getcwd(), 0
    keep.mkdir(exist_ok=True)
    place = Path(tempfile.mkdtemp(prefix="documents-"))
    try:
        roles.make_sound(place)
        os.chdir(place)
        sound = [files.read_recipe(f"{n}.png") for n in ("grown", "healed", "painted", "jittered")]
        kinds: dict[str, tuple[Callable[[Any, Random], bytes], list[Any], list[list[str]], str]] = {
            "map": (saved_map, [Path("map.npz").read_bytes()], [roles.line("render", saved="x.npz")], "x.npz"),
            "recipe": (recipe, sound, [roles.line("replay", picture="x.json")], "x.json"),
            "labels": (labels, [None], [roles.line("paint", **{f: "x.png"}) for f in ("labels", "target")], "x.png"),
        }  # fmt: skip
        for name, (make, seeds, lines, file) in kinds.items():
            draw, bad = Random(f"{name} {given.seed}"), 0
            for number in range(given.count):
                data = make(seeds[number % len(seeds)], draw)
                Path(file).write_bytes(data)
                wrong = trial(lines[number % len(lines)], place)
                if wrong:
                    bad += 1
                    (keep / f"{name}-{given.seed}-{number}{Path(file).suffix}").write_bytes(data)
                    print(json.dumps({"kind": name, "number": number, "wrong": wrong}), flush=True)
            print(json.dumps({"kind": name, "tried": given.count, "failed": bad}), flush=True)
            failed += bad
    finally:
        os.chdir(here)
        shutil.rmtree(place, ignore_errors=True)
    return failed


if __name__ == "__main__":
    sys.exit(min(main(), 100))
