"""The figures of Lopez Recas 2011 that are grown from a near-regular texture, one function each."""

from __future__ import annotations

from typing import Any

from ...exemplar import Exemplar
from ..figures import Figure, Panel, given, grown
from .goodness import lattice_by_goodness

TITLE = "Lopez Recas 2011, Constrained Random Sampling and Gap Filling for Near-regular Texture Synthesis"
USUAL = "sample:tiles"
ANYWHERE = ((1.0, 0.0), (0.0, 1.0))
SIZE = 400


def blocks(letter: str, exemplar: Exemplar, feather: int = 4, **more: Any) -> Panel:
    """A panel by random sampling and gap filling, with the source's settings but for those that are given."""
    given_ = {"detector": "goodness", "channel_weights": (1.0,)} | more
    return grown(letter, exemplar, SIZE, "gap-filling", given_, feather=feather)


def tile(letter: str, exemplar: Exemplar) -> Panel:
    """A panel by the best tile, repeated."""
    return grown(letter, exemplar, SIZE, "best-tile", {"lattice": lattice_by_goodness(exemplar, (1.0,))})


def quilted(letter: str, exemplar: Exemplar) -> Panel:
    """A panel by image quilting, with blocks as large: 50 px, 10 px of them shared."""
    return grown(letter, exemplar, SIZE, "raster-quilting", {"patch": 50, "overlap": 10})


def fits(exemplar: Exemplar) -> list[Panel]:
    """Figure 4.10: borders that fit by correlation, and by differences."""
    return [blocks("a", exemplar, fit="correlation"), blocks("b", exemplar, fit="difference")]


def gaps(exemplar: Exemplar) -> list[Panel]:
    """Figure 4.11: the best tile beside gap filling."""
    return [given(exemplar), tile("b", exemplar), blocks("c", exemplar, 0)]


def smoothed(exemplar: Exemplar) -> list[Panel]:
    """Figure 4.13: edges between blocks before and after they are smoothed."""
    return [blocks("a", exemplar, 0), blocks("b", exemplar)]


def compared(exemplar: Exemplar) -> list[Panel]:
    """Figure 5.2: the best tile, gap filling, image quilting."""
    return [given(exemplar), tile("b", exemplar), blocks("c", exemplar), quilted("d", exemplar)]


def wider(exemplar: Exemplar) -> list[Panel]:
    """Figure 5.12: blended over 4 px and over 28 px."""
    return [blocks("a", exemplar), blocks("b", exemplar, 28)]


def irregular(exemplar: Exemplar) -> list[Panel]:
    """Figure 5.13: from anywhere, beside image quilting."""
    return [given(exemplar), blocks("b", exemplar, lattice=ANYWHERE), quilted("c", exemplar)]


FIGURES = (
    Figure("4.10", "By correlation a little more blocky, by differences sharp edges fit a little worse.", fits, USUAL),
    Figure("4.11", "Random sampling introduces irregularities without visible repetitions.", gaps, USUAL),
    Figure("4.13", "The result after transitions have been smoothed.", smoothed, USUAL),
    Figure("5.2", "Near-regular textures are better synthesized so than by other approaches.", compared, USUAL),
    Figure("5.12", "A wider blending area reduces the blocky appearance.", wider, USUAL),
    Figure("5.13", "Irregular textures grow with the vectors 1,0 and 0,1.", irregular, "sample:pebbles"),
)
