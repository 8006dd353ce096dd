"""The patch size that suits an exemplar when none is given."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..analysis import valid_windows, without_patch
from ..analysis.elements import ElementSize, element_size
from ..analysis.features import features
from ..arrays import Pair
from ..errors import ParameterError
from ..exemplar import Exemplar, Exemplars, sampled
from ..geometry import ISOMETRIES
from ..guide import Guide
from ..lazy import lazy
from ..params import extent, words
from . import isometry_ids

if TYPE_CHECKING:
    from . import guide as guiding
else:  # where labels are asked for
    guiding = lazy("intarsia.search.guide")

LEAST = 16
USUAL = 64
LARGEST_SHARE = 0.6  # of the exemplar's shorter side
SUPPLY = 8  # at least 1/SUPPLY of the windows of an exemplar must be free of masked pixels


def elements(exemplar: Exemplar) -> ElementSize:
    """Return the size of the texture's elements, measured once for each exemplar."""
    return exemplar.memo("elements", lambda: element_size(features([exemplar]).pictures[0], exemplar.usable))


def default_patch(exemplars: Exemplars, guide: Guide | None = None) -> int:
    """Return a patch side in px: the size of the largest elements, or two small elements up to 64 px.

    Half an element breaks everything, and a fine regular texture keeps its rows only if a patch covers some. Under
    a guide with labels it suits the regions, and every label holds some, if that is possible.
    """
    if guide is not None and guide.is_labels:
        return _patch_of_labels(exemplars, guide)
    return supplied(exemplars, element_patch(exemplars))


def element_patch(exemplars: Exemplars) -> int:
    """Return a patch side in px for the largest elements, whatever masks leave."""
    used = sampled(exemplars)
    return fitting(max(elements(e).size for e in used), min(min(e.height, e.width) for e in used))


def large_patch(exemplars: Exemplars) -> int:
    """Return a patch side in px for seams of free shape: half as much again, up to 0.4 of the exemplar's side.

    Such a patch is hardly ever shown whole, so it may be larger than an element; more of it would show repeats.
    """
    plain = default_patch(exemplars)
    side = min(min(e.height, e.width) for e in sampled(exemplars))
    return supplied(exemplars, max(plain, min(3 * plain // 2, 2 * side // 5)))


def supplied(exemplars: Exemplars, patch: int, least: int = LEAST) -> int:
    """Return the largest patch side, px, up to `patch`, for which there are places enough that no mask touches.

    Below `least` one place is enough.
    """
    if all(e.usable is None for e in exemplars):
        return patch
    while patch > least and not any(SUPPLY * free >= every for free, every in _places(exemplars, patch)):
        patch = max(patch - max(patch // 8, 1), least)
    while patch > 1 and not any(free for free, _ in _places(exemplars, patch)):
        patch -= 1
    return patch


def _places(exemplars: Exemplars, patch: int) -> list[Pair]:
    """Of every exemplar, how many places there are for patches of this size: free of masked pixels, and in all."""
    free = [valid_windows((e.height, e.width), e.usable, e.toroidal, (patch, patch)) for e in exemplars]
    return [(int(np.count_nonzero(f)), max(f.size, 1)) for f in free]


def fitting(element: float, side: int) -> int:
    """Return a patch for elements of a size, in an exemplar of which the shorter side is `side` px."""
    wanted = max(element, min(2 * element, USUAL), LEAST)
    return int(min(wanted, max(LARGEST_SHARE * side, min(side, 3)), side))


def _patch_of_labels(exemplars: Exemplars, guide: Guide) -> int:
    """A patch for the elements of all regions, each measured in the largest square of its label.

    It stays below these squares, so that there is a choice of patches for every label.
    """
    guiding.check_sources(exemplars, guide)
    sizes, sides = [], []
    for found in guiding.largest_squares(exemplars, guide):
        if found is not None:
            number, y, x, side = found
            picture = features([exemplars[number]]).pictures[0][y : y + side, x : x + side]
            sizes.append(fitting(element_size(np.ascontiguousarray(picture), None).size, side))
            sides.append(max(int(LARGEST_SHARE * side), min(side, 3)))
    return min(max(sizes), *sides) if sizes else LEAST


def check_patch(
    patch: int | Pair,
    exemplars: Exemplars,
    isometries: str | tuple[int, ...] = "none",
    seams: int | Pair = 0,
) -> None:
    """Refuse a patch that fits into no unmasked part, or not into an exemplar that is sampled, or cannot be turned.

    `seams`: what a patch needs around itself on every side, px.
    """
    rows, columns = extent(patch)
    down, across = extent(seams)
    whole = (rows + 2 * down, columns + 2 * across)
    described = f"patch={words((rows, columns))}"
    if any((down, across)):
        described += f" with its seams of {words((down, across))} px"
    if whole[0] != whole[1] and any(ISOMETRIES[p].swaps for p in isometry_ids(isometries)):
        raise ParameterError(f"{described} is not square; rotations need a square patch.")
    for e in sampled(exemplars):
        if (whole[0] > e.height or whole[1] > e.width) and not e.toroidal:
            most = max(min(e.width - 2 * across, e.height - 2 * down), 0)
            choose = f"choose at most {most}" if most else "choose narrower seams"
            raise ParameterError(
                f"{described} is larger than the exemplar ({e.width} x {e.height} px); {choose}, or a larger exemplar."
            )
    if not any(valid_windows((e.height, e.width), e.usable, e.toroidal, (rows, columns)).any() for e in exemplars):
        raise without_patch((rows, columns))
