"""What each departure from the sources is worth: every switch off and on, over ten textures of several classes.

    python benchmarks/better.py FOLDER [sampling] [quilting] [striking] [painting]

FOLDER holds the pictures named in TEXTURES and PAIRS. One thing at a time is changed from the default; the tables
show the mean over ten textures and three seeds, and in brackets in how many of the ten the default is better than
the row. Measures:

* seam: difference of both sides of a seam, that is of a pixel's continuation and its neighbour, summed over all
  seams and divided by all pixels; in hundredths of the range of values. Smaller is better.
* contrast: mean difference of neighbours within 3 px of seams, as rendered, over that of the exemplar. 1 is best:
  less is a blur, more an edge. Wins count the distance from 1.
* repeat: every output pixel has a nearest other output pixel that shows the same exemplar pixel (the map tells
  which); the median of that distance over output pixels, px. No repeat counts as the output's diagonal. Larger
  is better. `near` is the distance below which a tenth of them lie.
* The table `striking` counts repeats of the most striking pixels alone, the rarest SHARE of the exemplar; `shown`
  is how often they are shown, in % of their share.
* used: share of the exemplar's pixels that are shown, %.
* agree, band: with labels, the share of pixels with the label asked for: in all, and within 24 px of a boundary, %.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch as swapped

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt

import intarsia as ia
from intarsia import files
from intarsia.analysis.features import features
from intarsia.analysis.saliency import rarity
from intarsia.foundation.geometry import ISOMETRIES
from intarsia.patches import patch_synthesis, repetition

SIDE, SEEDS, STEP, BAND, NEAR = 384, (1, 2, 3), 4, 24, 3
ELEMENT, SHARE = 32, 15  # px, within which a part is rare or not; % of the pixels that are called striking
TEXTURES = (
    "regular_gingham-cloth_256", "near-regular_brick-wall_256", "near-regular_wicker_192", "irregular_pebbles_256",
    "irregular_reptile-scales_256", "irregular_autumn-leaves_256", "near-stochastic_wood-knots_256",
    "near-stochastic_sand-ripples_320", "stochastic_hedge_256", "stochastic_granite-concrete_256",
)  # fmt: skip
PAIRS = ("near-stochastic_beach-plants-two-regions_512", "near-stochastic_plaster-stone-two-regions_512")
J = np.array([i.j for i in ISOMETRIES])
SOURCE = ia.PatchSampling(patch=25, overlap=5)
FAR = 10_000
LARGER = {"repeat", "near", "used", "agree", "band"}


class Spread(ia.PatchSampling):
    """Patch sampling whose windows are spread to end at the border, in place of hanging over it."""

    hangs = None


class AsThere(ia.PatchSampling):
    """Patch sampling with all as in the source: also colours that count alike, and seams mixed as numbers of the file.

    Without prevention of repetitions the order does not matter: windows see the same whether by rows or by diagonals.
    """

    @property
    def blend(self) -> ia.Blend:
        """The method's, mixed as in the source."""
        return super().blend.but(mixing="source")

    def synthesize(self, exemplars: Any, canvas: Any, seed: int, run: ia.Run) -> ia.SourceMap:
        """As the method does, with weights for as many channels as there are."""
        alike = (1.0,) * exemplars[0].base.channels
        plain = ia.PatchSampling.synthesize
        return plain(replace(self, channel_weights=alike), exemplars, canvas, seed, run)


@dataclass(frozen=True)
class Switch:
    """One row of a table: a method, and what else is changed while it runs; under labels their weight and reach."""

    method: Any
    changed: tuple[tuple[Any, str, Any], ...] = ()
    weight: float = 2.0
    reach: int = 0


FARAWAY = ((repetition, "REACH", 0),)
EVENLY = ((repetition, "REACH", 0), (repetition, "STEADY", 1.0))
TOGETHER = ((repetition.Repetition, "apart", lambda self, groups: None),)
PLAIN = ((patch_synthesis, "striking", lambda feats, finder: None),)
DRIFTING = ((repetition, "DRIFT", 1e9),)
SAMPLING = {
    "default": Switch(SOURCE),
    "all as in the source": Switch(AsThere(patch=25, overlap=5, search="exact", repetition="none")),
    "repetition: none": Switch(replace(SOURCE, repetition="none")),
    "repetition: counter": Switch(replace(SOURCE, repetition="counter")),
    "repetition: marks": Switch(replace(SOURCE, repetition="marks")),
    "prices without nearness": Switch(SOURCE, FARAWAY),
    "the full price anywhere, near or far": Switch(SOURCE, EVENLY),
    "prices alike for all patches": Switch(SOURCE, PLAIN),
    "prices without drift": Switch(SOURCE, DRIFTING),
    "bound: epsilon 0.1": Switch(replace(SOURCE, bound="epsilon")),
    "search: exact": Switch(replace(SOURCE, search="exact")),
    "search: pyramid, drawn": Switch(replace(SOURCE, pyramid="mean", pyramid_draws="every")),
    "search: pyramid, 1 kept": Switch(replace(SOURCE, pyramid="mean", pyramid_kept=1)),
    "search: pyramid, 8 kept": Switch(replace(SOURCE, pyramid="mean")),
    "search: pyramid, 8 kept, gaussian": Switch(replace(SOURCE, pyramid="gaussian")),
    "join: cut": Switch(replace(SOURCE, join="cut")),
    "join: middle": Switch(replace(SOURCE, join="middle")),
    "isometries: auto": Switch(replace(SOURCE, isometries="auto")),
    "isometries: both": Switch(replace(SOURCE, isometries="both")),
    "windows spread, not hanging over the border": Switch(Spread(patch=25, overlap=5)),
}
QUILT = ia.ImageQuilting()
QUILTING = {
    "default": Switch(QUILT),
    "repeat_penalty: 0": Switch(replace(QUILT, repeat_penalty=0.0)),
    "prices without nearness": Switch(QUILT, FARAWAY),
    "the full price anywhere, near or far": Switch(QUILT, EVENLY),
    "prices alike for all patches": Switch(QUILT, PLAIN),
    "prices without drift": Switch(QUILT, DRIFTING),
    "tolerance: 0": Switch(replace(QUILT, tolerance=0.0)),
    "search: exact": Switch(replace(QUILT, search="exact")),
    "seam: gradient": Switch(replace(QUILT, seam="gradient")),
    "isometries: auto": Switch(replace(QUILT, isometries="auto")),
    "isometries: both": Switch(replace(QUILT, isometries="both")),
}
STRIKING = {
    f"{who}, {name}": Switch(method, changed)
    for who, method in (("sampling", SOURCE), ("quilting", QUILT))
    for name, changed in (("default", ()), ("prices alike for all patches", PLAIN))
}
PAINTED = ia.PatchSampling()
PAINTING = {
    "quilting, default": Switch(QUILT),
    "weight: 0": Switch(QUILT, weight=0.0),
    "weight: 0.5": Switch(QUILT, weight=0.5),
    "weight: 5": Switch(QUILT, weight=5.0),
    "boundary_patch: as large": Switch(replace(QUILT, boundary_patch=0)),
    "boundary_isometries: none": Switch(replace(QUILT, boundary_isometries="none")),
    "boundary_tolerance: any": Switch(replace(QUILT, boundary_tolerance=FAR)),
    "boundary: all three off": Switch(
        replace(QUILT, boundary_patch=0, boundary_isometries="none", boundary_tolerance=FAR)
    ),
    "reach: 12": Switch(QUILT, reach=12),
    "repeat_penalty: 0": Switch(replace(QUILT, repeat_penalty=0.0)),
    "one count for all labels": Switch(QUILT, TOGETHER),
    "prices without drift": Switch(QUILT, DRIFTING),
    "sampling, default": Switch(PAINTED),
    "sampling, boundary_join: same": Switch(replace(PAINTED, boundary_join="same")),
    "sampling, repetition: none": Switch(replace(PAINTED, repetition="none")),
}  # fmt: skip


@contextmanager
def applied(switch: Switch) -> Iterator[None]:
    """Change what the switch changes, for as long as it runs."""
    with ExitStack() as stack:
        for where, name, value in switch.changed:
            stack.enter_context(swapped.object(where, name, value))
        yield


def seam_cost(out: ia.Synthesis, where: np.ndarray | None = None) -> tuple[float, np.ndarray]:
    """Difference of both sides of all seams, over all pixels (or those of a mask); and which pixels lie at a seam."""
    pixels = values(np.asarray(out.exemplars[0].base))
    yx, shown = out.map.yx.astype(int), values(np.asarray(out.render(feather=0)))
    pose = np.zeros(yx.shape[:2], int) if out.map.pose is None else out.map.pose.astype(int)
    total, at = np.zeros(pose.shape), np.zeros(pose.shape, bool)
    for axis in (0, 1):
        there = tuple(slice(1, None) if a == axis else slice(None) for a in (0, 1))
        here = tuple(slice(None, -1) if a == axis else slice(None) for a in (0, 1))
        on = yx[here] + J[pose[here]][:, :, :, axis]
        jump = (on != yx[there]).any(axis=2)
        on = np.clip(on, 0, np.array(pixels.shape[:2]) - 1)
        apart = np.abs(pixels[on[:, :, 0], on[:, :, 1]] - shown[there]).mean(axis=2)
        total[there] += np.where(jump, apart, 0)
        at[there] |= jump
    return 100 * float((total if where is None else total[where]).mean()), at


def values(pixels: np.ndarray) -> np.ndarray:
    """Pixels as (H, W, C) floats of 0 to 1."""
    wide = pixels[:, :, None] if pixels.ndim == 2 else pixels
    return wide.astype(float) / np.iinfo(wide.dtype).max


def contrast(out: ia.Synthesis, at: np.ndarray) -> float:
    """Mean difference of neighbours near seams as rendered, over that of the exemplar."""
    near = binary_dilation(at, np.ones((3, 3)), NEAR - 1)
    made, exemplar = values(np.asarray(out.render())), values(np.asarray(out.exemplars[0].base))
    return float(steps(made)[near[1:, 1:]].mean() / steps(exemplar).mean()) if near.any() else 1.0


def steps(picture: np.ndarray) -> np.ndarray:
    """Mean difference of every pixel to the one above and the one to the left."""
    up = np.abs(picture[1:, 1:] - picture[:-1, 1:])
    left = np.abs(picture[1:, 1:] - picture[1:, :-1])
    return np.asarray((up + left).mean(axis=2))


def repeats(smap: ia.SourceMap, counted: np.ndarray | None = None) -> np.ndarray:
    """Distance of every pixel that shows a pixel of each STEP x STEP of the exemplar to the nearest that shows it.

    `counted`, a mask of the exemplar: these of its pixels alone.
    """
    yx = smap.yx.astype(np.int64)
    chosen = (yx % STEP == 0).all(axis=2)
    if counted is not None:
        chosen &= counted[yx[:, :, 0], yx[:, :, 1]]
    at = np.argwhere(chosen)
    key = yx[chosen][:, 0] * (1 << 20) + yx[chosen][:, 1]
    order = np.argsort(key, kind="stable")
    at, key = at[order], key[order]
    least = np.full(len(at), float(np.hypot(*smap.yx.shape[:2])))
    for gap in range(1, len(at)):
        same = np.flatnonzero(key[gap:] == key[:-gap])
        if not len(same):
            break
        apart = np.hypot(*(at[same + gap] - at[same]).T)
        np.minimum.at(least, same, apart)
        np.minimum.at(least, same + gap, apart)
    return least


def measures(out: ia.Synthesis) -> dict[str, float]:
    """All measures that need no labels."""
    seam, at = seam_cost(out)
    apart = repeats(out.map)
    shown = np.zeros(out.exemplars[0].base.pixels.shape[:2], bool)
    shown[out.map.yx[:, :, 0], out.map.yx[:, :, 1]] = True
    return {
        "seam": seam, "contrast": contrast(out, at), "repeat": float(np.median(apart)),
        "near": float(np.percentile(apart, 10)), "used": 100 * float(shown.mean()),
    }  # fmt: skip


def grown(folder: Path, switch: Switch, number: int) -> dict[str, float]:
    """Grow one texture from several seeds and measure it."""
    exemplar = ia.read(folder / f"{TEXTURES[number]}.png")
    with applied(switch):
        return mean([measures(ia.synthesize(exemplar, SIDE, switch.method, seed=seed)) for seed in SEEDS])


def struck(folder: Path, switch: Switch, number: int) -> dict[str, float]:
    """Grow one texture from several seeds and measure how its most striking pixels repeat."""
    exemplar = ia.read(folder / f"{TEXTURES[number]}.png")
    grid, step = rarity(features([exemplar]).pictures[0], ELEMENT)
    y, x = (np.clip((np.arange(n) - ELEMENT // 2) // step, 0, m - 1)
            for n, m in zip((exemplar.height, exemplar.width), grid.shape, strict=True))  # fmt: skip
    rare = grid[np.ix_(y, x)]
    top = rare >= np.percentile(rare, 100 - SHARE)
    found = []
    with applied(switch):
        for seed in SEEDS:
            smap = ia.synthesize(exemplar, SIDE, switch.method, seed=seed).map
            apart = repeats(smap, top)
            shown = top[smap.yx[:, :, 0], smap.yx[:, :, 1]].mean() / top.mean()
            found.append({"repeat": np.median(apart), "near": np.percentile(apart, 10), "shown": 100 * shown})
    return mean(found)


def mean(found: list[dict[str, float]]) -> dict[str, float]:
    """The mean of every measure."""
    return {key: float(np.mean([f[key] for f in found])) for key in found[0]}


def pair(folder: Path, number: int) -> tuple[ia.Exemplar, ia.Plane]:
    """An exemplar of two labels: a photograph that holds both, or two side by side along a waving line."""
    if number < len(PAIRS):
        name = PAIRS[number]
        return ia.read(folder / f"{name}.png"), files.read_plane(folder / f"{name}.labels.png", ia.Kind.LABEL)
    first, second = (np.asarray(ia.read(folder / f"{TEXTURES[n]}.png").base) for n in (number - 2, number - 1))
    side = min(*first.shape[:2], *second.shape[:2])
    first, second = (np.dstack([p] * 3) if p.ndim == 2 else p[:, :, :3] for p in (first, second))
    y, x = np.mgrid[:side, :side]
    labels = (x + np.round(12 * np.sin(y / 15)) >= side / 2).astype(np.uint8)
    mixed = np.where(labels[:, :, None] > 0, second[:side, :side], first[:side, :side])
    return ia.Exemplar.of(np.ascontiguousarray(mixed)), ia.Plane(labels, ia.Kind.LABEL)


def target_of(number: int, names: tuple[int, int], side: int = SIDE) -> np.ndarray:
    """A disc, stripes and a coast in turn."""
    y, x = np.mgrid[:side, :side]
    masks = (
        (y - side / 2) ** 2 + (x - side / 2) ** 2 < (side / 3) ** 2,
        (x + y) // 70 % 2 == 0,
        np.sin(x / 40) * 30 + side / 2 + 20 * np.sin(x / 17 + 1) < y,
    )
    return np.where(masks[number % 3], *names).astype(np.uint8)


def painted(folder: Path, switch: Switch, number: int) -> dict[str, float]:
    """Paint with one pair of labels and measure it; seams count near boundaries."""
    exemplar, marks = pair(folder, number)
    first, second = np.unique(marks.pixels).tolist()
    target = target_of(number, (first, second))
    guide = ia.Guide(marks, ia.Plane(target, ia.Kind.LABEL), switch.weight, switch.reach)
    with applied(switch):
        made = [ia.synthesize(exemplar, None, switch.method, guide=guide, seed=seed) for seed in SEEDS]
    return mean([painting_measures(out, marks, target) for out in made])


def painting_measures(out: ia.Synthesis, marks: ia.Plane, target: np.ndarray) -> dict[str, float]:
    """Label agreement, in all and near boundaries; the other measures, seams and contrast near boundaries."""
    labels = marks.pixels.reshape(marks.height, marks.width)
    same = labels[out.map.yx[:, :, 0], out.map.yx[:, :, 1]] == target
    inner = target == target[0, 0]
    band = np.maximum(distance_transform_edt(inner), distance_transform_edt(~inner)) <= BAND
    told = measures(out)
    seam, at = seam_cost(out, band)
    return {
        "agree": 100 * float(same.mean()), "band": 100 * float(same[band].mean()), "seam": seam,
        "contrast": contrast(out, at & band), "repeat": told["repeat"],
    }  # fmt: skip


def table(switches: dict[str, Switch], one: Callable[[Switch, int], dict[str, float]]) -> None:
    """Print a markdown table: the mean over ten, and in brackets in how many of them the row before is better.

    "The row before" is the last one that is called a default.
    """
    ten = range(10)
    default: list[dict[str, float]] = []
    for name, switch in switches.items():
        found = [one(switch, n) for n in ten]
        if "default" in name:
            if not default:
                print(f"| | {' | '.join(found[0])} |\n|---|{'---|' * len(found[0])}")
            default = found
        cells = []
        for key in found[0]:
            whole = np.mean([f[key] for f in found])
            wins = sum(goodness(key, d[key]) > goodness(key, f[key]) for d, f in zip(default, found, strict=True))
            cells.append(f"{whole:.3g}" if found is default else f"{whole:.3g} ({wins})")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def goodness(key: str, value: float) -> float:
    """A number that is larger where the measure is better."""
    return -abs(value - 1) if key == "contrast" else value if key in LARGER else -value


def main(where: str, *asked: str) -> None:
    """Print the tables."""
    folder = Path(where)
    for name, switches, one in (
        ("sampling", SAMPLING, grown), ("quilting", QUILTING, grown), ("striking", STRIKING, struck),
        ("painting", PAINTING, painted),
    ):  # fmt: skip
        if not asked or name in asked:
            print(f"\n{name}\n")
            table(switches, lambda switch, n, one=one: one(folder, switch, n))


if __name__ == "__main__":
    main(*sys.argv[1:])
