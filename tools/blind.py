"""Compare two versions of intarsia by eye, or one with photographs, without knowing which is which.

    python tools/blind.py grow A=OLD_TREE B=. EXEMPLAR... -o OUT [--seeds 1 2 3] [--size 512] [--options "-m graphcut"]
    python tools/blind.py sheets OUT --seed 7
    python tools/blind.py count OUT GRADES.csv [-o VERDICTS.csv]

``grow`` grows every exemplar with both trees of the source (folders that hold ``src/intarsia``) into ``OUT/A`` and
``OUT/B``; ``B=photograph`` takes the middle of what the exemplar was cut from, ``NAME.ref.png`` beside ``NAME.png``,
where that is larger. ``sheets`` lays each exemplar beside its two pictures, in an order and under names that only
``OUT/key.json`` tells; whoever grades them writes a line ``sheet,grade of the left,of the right,preferred,remarks``
for each: grades are G (good), F (flawed) and B (broken), preferred is L, R or =. ``count`` tells what was said of which
version.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import random
import shlex
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
from PIL import Image

PHOTOGRAPH = "photograph"  # in place of a tree
GAP, DARK, MOST = 12, (40, 40, 40), 320  # px between pictures, their ground, px of an exemplar a side


def name_of(exemplar: Path) -> str:
    return exemplar.name.split(".")[0]


def grow(
    versions: dict[str, Path], exemplars: list[Path], out: Path, seeds: list[int], size: int, options: str
) -> None:
    """Grow the exemplars with each tree; what is there already stays."""
    for version, tree in versions.items():
        for seed in seeds:
            folder = out / version / str(seed)
            folder.mkdir(parents=True, exist_ok=True)
            for exemplar in exemplars:
                made = folder / f"{name_of(exemplar)}.png"
                if made.exists():
                    continue
                if str(tree) == PHOTOGRAPH:
                    photographed(exemplar, made, size)
                    continue
                command = [sys.executable, "-m", "intarsia", "grow", str(exemplar.resolve()), "-o", str(made.resolve())]
                command += ["--size", str(size), "--seed", str(seed), "--quiet", *shlex.split(options)]
                environment = {**os.environ, "PYTHONPATH": str((tree / "src").resolve())}
                done = subprocess.run(command, env=environment, check=False)
                if done.returncode:
                    print(f"{version}: {exemplar.name} seed {seed} ended with {done.returncode}.", file=sys.stderr)
    (out / "exemplars.json").write_text(json.dumps({name_of(e): str(e.resolve()) for e in exemplars}))


def photographed(exemplar: Path, made: Path, size: int) -> None:
    """Write the middle of what an exemplar was cut from, where that is known and larger."""
    whole = exemplar.with_name(f"{exemplar.stem}.ref{exemplar.suffix}")
    if not whole.exists():
        return
    shown = picture(whole)
    height, width = min(size, shown.height), min(size, shown.width)
    with Image.open(exemplar) as small:
        if height <= small.height or width <= small.width:
            return
    left, top = (shown.width - width) // 2, (shown.height - height) // 2
    shown.crop((left, top, left + width, top + height)).save(made)


def picture(path: Path, most: int | None = None) -> Image.Image:
    with Image.open(path) as image:
        if image.mode.startswith("I"):  # 16 bit
            deep = np.asarray(image, np.float64)
            image = Image.fromarray((deep * (255 / max(deep.max(), 1))).astype(np.uint8))
        shown = image.convert("RGB")
    if most and max(shown.size) > most:
        shown.thumbnail((most, most))
    return shown


def sheet(pictures: list[Image.Image]) -> Image.Image:
    whole = Image.new("RGB", (sum(p.width + GAP for p in pictures) - GAP, max(p.height for p in pictures)), DARK)
    x = 0
    for one in pictures:
        whole.paste(one, (x, 0))
        x += one.width + GAP
    return whole


def sheets(out: Path, seed: int) -> int:
    """Lay every pair out under a number, shuffled; return how many there are."""
    exemplars = json.loads((out / "exemplars.json").read_text())
    first, second = sorted(p.name for p in out.iterdir() if p.is_dir() and p.name != "sheets")
    pairs = sorted(p.relative_to(out / first) for p in (out / first).glob("*/*.png"))
    pairs = [p for p in pairs if (out / second / p).exists()]
    dice, key = random.Random(seed), {}
    dice.shuffle(pairs)
    (out / "sheets").mkdir(exist_ok=True)
    for number, pair in enumerate(pairs):
        sides = [first, second]
        dice.shuffle(sides)
        shown = [picture(Path(exemplars[pair.stem]), MOST), *(picture(out / side / pair) for side in sides)]
        sheet(shown).save(out / "sheets" / f"{number:03d}.png")
        key[f"{number:03d}"] = {"texture": pair.stem, "seed": int(pair.parent.name), "L": sides[0], "R": sides[1]}
    (out / "key.json").write_text(json.dumps(key, indent=1))
    return len(pairs)


def count(out: Path, grades: Path, to: Path | None) -> str:
    """Tell grades and preferences by version, and write a line for each picture where `to` is given."""
    key, told, rows = json.loads((out / "key.json").read_text()), Counter[tuple[str, str]](), []
    for line in csv.reader(grades.read_text().splitlines()):
        number, left, right, preferred, *remarks = (part.strip() for part in line)
        if not number.isdigit():
            continue  # the head of the table
        known = key[number.zfill(3)]
        if not {left, right} <= set("GFB") or preferred not in "LR=":
            raise SystemExit(f"{grades}: sheet {number} has grades {left}, {right} and preference {preferred}.")
        better = known.get(preferred, "=")
        told.update([(known["L"], left), (known["R"], right), (better, "preferred")])
        by = {known["L"]: left, known["R"]: right}
        rows.append([known["texture"], known["seed"], *(by[v] for v in sorted(by)), better, "; ".join(remarks)])
    versions = sorted({v for one in key.values() for v in (one["L"], one["R"])})
    if to is not None:
        with to.open("w", newline="") as file:
            csv.writer(file).writerows([["texture", "seed", *versions, "preferred", "remarks"], *sorted(rows)])
    lines = [
        f"{v}: good {told[v, 'G']}, flawed {told[v, 'F']}, broken {told[v, 'B']}; preferred {told[v, 'preferred']}"
        for v in versions
    ]
    return "\n".join([*lines, f"equal: {told['=', 'preferred']}, of {len(rows)} sheets"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    actions = parser.add_subparsers(dest="action", required=True)
    growing = actions.add_parser("grow")
    growing.add_argument("given", nargs="+", help="A=TREE B=TREE, then exemplars")
    growing.add_argument("-o", "--out", type=Path, required=True)
    growing.add_argument("--seeds", type=int, nargs="+", default=[1])
    growing.add_argument("--size", type=int, default=512)
    growing.add_argument("--options", default="", help="further options of intarsia grow, in one string")
    laying = actions.add_parser("sheets")
    laying.add_argument("out", type=Path)
    laying.add_argument("--seed", type=int, default=1)
    counting = actions.add_parser("count")
    counting.add_argument("out", type=Path)
    counting.add_argument("grades", type=Path)
    counting.add_argument("-o", "--to", type=Path)
    given = parser.parse_args()
    if given.action == "grow":
        trees = dict(part.split("=", 1) for part in given.given if "=" in part)
        exemplars = [Path(part) for part in given.given if "=" not in part]
        if len(trees) != 2 or not exemplars:
            parser.error("give two trees as NAME=FOLDER, and exemplars.")
        versions = {name: Path(tree) for name, tree in trees.items()}
        grow(versions, exemplars, given.out, given.seeds, given.size, given.options)
    elif given.action == "sheets":
        print(f"{sheets(given.out, given.seed)} sheets in {given.out / 'sheets'}; the key is {given.out / 'key.json'}")
    else:
        print(count(given.out, given.grades, given.to))


if __name__ == "__main__":
    main()
