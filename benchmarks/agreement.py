"""How far the score agrees with people: weights are fitted to grades, and tried on textures that were left out.

    python benchmarks/agreement.py --sheets VERDICTS --graded GRADES.md PICTURES --textures FOLDER... [--grow]

VERDICTS holds ``verdicts.csv`` (texture, grades G/F/B of two people for each of two programs, which they preferred) and
one sheet for each texture: exemplar, and both pictures side by side. GRADES.md has a table of one grade for each
texture and program, whose pictures are ``PICTURES/TEXTURE__PROGRAM.jpg``, grown from at most 256 x 256 px. None of it
is part of the project: what is kept of it are the weights, and the table of agreement in docs/score.md. With ``--grow``
the pictures of ``compared.csv`` (beside this file) are grown again with seed 1, and its third grader is heard, too.
"""

from __future__ import annotations

import argparse
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.optimize import minimize
from skimage.feature import local_binary_pattern

import intarsia as ia
from intarsia.analysis import blocks
from intarsia.judging import Score, judge
from intarsia.judging.parts import PARTS, TEXTURE
from intarsia.model import Exemplar
from unweighed import of_picture

GRADES = {"G": 2, "F": 1, "B": 0}
SHEET = {"ours": (16, 264), "quilting": (16, 784)}  # where the pictures of a sheet begin, (y, x) px
SIDE = 512  # px of each
RIDGE = 1.0  # how strongly weights are held small, for parts of spread 1
COUNTS = {"two": 2.0, "one": 0.5, "third": 1.5}  # how much a pair counts

Pixels = NDArray[np.uint8]


@dataclass(frozen=True)
class Pair:
    """Two pictures of one texture, of which people call the first better."""

    texture: str
    better: str
    worse: str
    by: str  # "two" people who do not know of one another, "one" who gave grades, or a "third" who compared methods
    apart: int  # grades between them


@dataclass(frozen=True)
class Judged:
    """What is measured of one picture."""

    score: Score
    plain: dict[str, float]


def pixels(path: Path) -> Pixels:
    with Image.open(path) as image:
        if image.mode.startswith("I"):
            deep = np.asarray(image, np.float64)
            return np.repeat((deep / max(deep.max(), 1) * 255).astype(np.uint8)[..., None], 3, axis=2)
        if image.mode in ("RGBA", "LA", "P"):
            black = Image.new("RGBA", image.size, (0, 0, 0, 255))
            return np.asarray(Image.alpha_composite(black, image.convert("RGBA")).convert("RGB"))
        return np.asarray(image.convert("RGB"))


def exemplar_of(texture: str, folders: list[Path]) -> Pixels:
    for folder in folders:
        for ending in (".png", ".albedo.png"):
            if (folder / (texture + ending)).exists():
                return pixels(folder / (texture + ending))
    raise SystemExit(f"{texture}: not found in the folders of --textures.")


def pairs_of_sheets(folder: Path) -> Iterator[Pair]:
    with (folder / "verdicts.csv").open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            first, second = row["preferred_1"], row["preferred_2"]
            if first == second and first in SHEET:
                (other,) = set(SHEET) - {first}
                marks = {p: [GRADES[row[f"{p}_{n}"]] for n in (1, 2)] for p in SHEET}
                yield Pair(row["texture"], first, other, "two", min(marks[first]) - max(marks[other]))


def pairs_of_grades(table: Path) -> Iterator[Pair]:
    programs: list[str] = []
    for line in table.read_text(encoding="utf-8").splitlines():
        cells = [c.strip() for c in line.strip("| ").split("|")]
        if cells[0] == "exemplar":
            programs = [c.replace("quilting ", "quilting-") for c in cells[1:]]
        elif programs and re.fullmatch(r"[\w-]+_\w+", cells[0]) and len(cells) == len(programs) + 1:
            marks = dict(zip(programs, (GRADES[c] for c in cells[1:]), strict=True))
            for a, b in permutations(programs, 2):
                if marks[a] > marks[b]:
                    yield Pair(cells[0], a, b, "one", marks[a] - marks[b])


def pairs_of_methods() -> Iterator[Pair]:
    with Path(__file__).with_name("compared.csv").open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            both = {row["method"], "graphcut"}
            if row["preferred"] in both:
                (other,) = both - {row["preferred"]}
                yield Pair(row["texture"], row["preferred"], other, "third", 0)


def judged(exemplar: Pixels, output: Pixels) -> Judged:
    """The score, and measures beside it: smaller is better."""
    mine, shown = Exemplar.of(exemplar), Exemplar.of(output)
    gray = [p.astype(np.float64) @ (0.299, 0.587, 0.114) for p in (exemplar, output)]
    marks = (local_binary_pattern(g.astype(np.uint8), 8, 1, "uniform").astype(int).ravel() for g in gray)
    a, b = (np.bincount(m, minlength=10) / m.size for m in marks)
    apart = float(((a - b) ** 2 / (a + b + 1e-9)).sum())
    plain = {"LBP": apart, "SSIM": _ssim(*gray), "moments": _moments(*gray)}
    return Judged(judge([mine], shown).score, plain | of_picture(mine, shown))


def _moments(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return abs(a.mean() - b.mean()) / 255 + abs(a.std() - b.std()) / 255


def _ssim(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """One less the mean likeness of 64 px squares of the output to the most alike of the exemplar, on a quarter."""
    from skimage.metrics import structural_similarity

    a, b = (blocks(p, 4).mean(axis=(1, 3)) for p in (a, b))
    best = []
    for y in range(0, b.shape[0] - 15, 32):
        for x in range(0, b.shape[1] - 15, 32):
            square = b[y : y + 16, x : x + 16]
            spots = product(range(0, a.shape[0] - 15, 6), range(0, a.shape[1] - 15, 6))
            some = [a[i : i + 16, j : j + 16] for i, j in spots]
            best.append(max(structural_similarity(square, s, data_range=255) for s in some))
    return 1 - float(np.mean(best))


WEIGHED = tuple(part for part in PARTS if part is not TEXTURE)  # what others are is not fitted


def faults(one: Score) -> NDArray[np.float64]:
    """What each part takes away, before its weight."""
    return np.array([(one.grain if p.grainy else 1.0) * (1 - one.parts[p.name].normalised) ** 0.5 for p in PARTS])


def fitted(steps: NDArray[np.float64], counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights, none below 0, that make the better of two likely (Bradley and Terry 1952), held small."""
    spread = steps.std(axis=0) + 1e-9
    scaled = steps / spread

    def loss(w: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        margin = scaled @ w
        wrong = counts / (1 + np.exp(margin))
        return float((counts * np.logaddexp(0, -margin)).sum() + RIDGE * (w @ w)), -scaled.T @ wrong + 2 * RIDGE * w

    start = np.full(steps.shape[1], 0.1)
    return np.asarray(minimize(loss, start, jac=True, bounds=[(0, None)] * len(start), method="L-BFGS-B").x) / spread


def left_out(steps: NDArray[np.float64], counts: NDArray[np.float64], textures: NDArray[np.str_]) -> NDArray[Any]:
    """By how much the better is better, for every pair, with weights fitted to the other textures."""
    out = np.empty(len(steps))
    for texture in np.unique(textures):
        here = textures == texture
        out[here] = steps[here] @ fitted(steps[~here], counts[~here])
    return out


def groups(pairs: list[Pair]) -> dict[str, NDArray[np.bool_]]:
    """The pairs by what is known of them; groups without any are left out."""
    found = {
        "two people agree": [p.by == "two" for p in pairs],
        "grades differ": [p.by == "one" for p in pairs],
        "good and broken": [p.by == "one" and p.apart == 2 for p in pairs],
        "a third person": [p.by == "third" for p in pairs],
    }
    return {name: np.array(which) for name, which in found.items() if any(which)}


def say(name: str, margin: NDArray[np.float64], pairs: list[Pair]) -> None:
    """Print in how many of the pairs the better is named; a tie is half."""
    named = (margin > 0) + 0.5 * (margin == 0)
    shares = [f"{100 * named[which].mean():.0f} %" for which in groups(pairs).values()]
    print(f"| {name} | {' | '.join(shares)} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sheets", type=Path, required=True)
    parser.add_argument("--graded", type=Path, nargs=2, required=True)
    parser.add_argument("--textures", type=Path, nargs="+", required=True)
    parser.add_argument("--grow", action="store_true")
    given = parser.parse_args()
    pairs = [*pairs_of_sheets(given.sheets), *pairs_of_grades(given.graded[0])]
    pairs += pairs_of_methods() if given.grow else ()
    seen: dict[tuple[str, str], Judged] = {}
    for p in pairs:
        exemplar = exemplar_of(p.texture, given.textures)
        for program in (p.better, p.worse):
            if (p.texture, program) in seen:
                continue
            if p.by == "third":
                made = ia.synthesize(exemplar, SIDE, program, seed=1)
                output = np.asarray(made.render().pixels)
            elif p.by == "two":
                y, x = SHEET[program]
                output = pixels(given.sheets / f"{p.texture}.jpg")[y : y + SIDE, x : x + SIDE]
            else:
                exemplar = exemplar[:256, :256]
                output = pixels(given.graded[1] / f"{p.texture}__{program}.jpg")
            seen[p.texture, program] = judged(exemplar, output)
    textures = np.array([p.texture for p in pairs])
    counts = np.array([COUNTS[p.by] for p in pairs])
    of = lambda p, program: seen[p.texture, program]  # noqa: E731
    steps = np.array([faults(of(p, p.worse).score) - faults(of(p, p.better).score) for p in pairs])
    heads = [f"{name} ({which.sum()})" for name, which in groups(pairs).items()]
    print(f"| the better is named | {' | '.join(heads)} |\n|:---|{'---:|' * len(heads)}")
    for k, part in enumerate(PARTS):
        say(part.name, steps[:, k], pairs)
    for name in ("LBP", "SSIM", "moments", "strange", "lost"):
        say(name, np.array([of(p, p.worse).plain[name] - of(p, p.better).plain[name] for p in pairs]), pairs)
    weighed = steps[:, [PARTS.index(part) for part in WEIGHED]]
    margin = left_out(weighed, counts, textures)
    say("all, weights of the other textures", margin, pairs)
    say("all, as shipped", np.array([of(p, p.better).score.total - of(p, p.worse).score.total for p in pairs]), pairs)
    weights = fitted(weighed, counts)
    print({p.name: round(float(w), 4) for p, w in zip(WEIGHED, weights / weights.sum(), strict=True)})
    for p, m in sorted(zip(pairs, margin, strict=True), key=lambda one: one[1]):
        if m <= 0:
            print(f"missed: {p.texture}, {p.better} over {p.worse} ({m:.2f})")


if __name__ == "__main__":
    main()
