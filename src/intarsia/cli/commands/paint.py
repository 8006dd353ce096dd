"""``intarsia paint``: a texture whose regions are where you paint them. Imports nothing heavy before the work."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click

from ...arguments import REACHES, SAMPLES, WEIGHT, WEIGHTS
from ...choosing.auto import AUTO_METHOD
from ...methods.base import METHODS, Ability, method_class
from ..options import EXEMPLARS, FILE, PLANE_WEIGHTS, gathered, input_options, offered, opt
from ..request import Labels, Wish
from ..values import Number
from .grow import METHOD, growing, wish_of
from .grow import OWN as GROWN

GUIDED = tuple(slug for slug in METHODS if Ability.GUIDE in method_class(slug).supports)

OWN = (
    opt(
        "labels", "--labels", "-l", multiple=True, required=True, type=FILE, metavar="FILE",
        help="Which pixel of the exemplar is what. One colour for each label; once for each exemplar.",
    ),
    opt(
        "target", "--target", "-t", required=True, type=FILE, metavar="FILE",
        help="Where each label shall be. In the same colours; the output has its size.",
    ),
    opt(
        "weight", "--weight", type=Number(0, WEIGHTS), default=WEIGHT, show_default=True, metavar="F",
        help="How closely boundaries follow the target. 1.5 to 2.5 mostly; 0 takes what joins best.",
    ),
    opt(
        "reach", "--reach", type=click.IntRange(0, REACHES), default=0, show_default=True, metavar="PX",
        help="Pixels this near to a boundary count as partly of both labels.",
    ),
    METHOD.but(type=click.Choice([AUTO_METHOD, *GUIDED]), help="How to grow; `intarsia methods` tells of each."),
    *(o for o in GROWN if o.field in ("explain", "wrap", "feather", "mixing", "level", "repair")),
)  # fmt: skip

UNION, PARAMETERS = offered(GUIDED, *OWN)
PLANES = replace(PLANE_WEIGHTS, names=("--plane-weight",))  # --weight is that of the target


def _wish(labels: tuple[str, ...], target: str, weight: float, reach: int, **given: Any) -> Wish:
    return wish_of(labels=Labels(labels, target, weight, reach), union=UNION, **given)


@growing(
    "paint", "painted", input_options(EXEMPLARS, PLANES, without=("weights",)),
    gathered(*OWN, *PARAMETERS, into="wish", make=_wish),
    epilog=f"Built-in exemplars: {', '.join('sample:' + s for s in SAMPLES)}. OUT may hold {{seed}}, {{method}}, "
    "{w} and {h}; with --seeds every seed makes an output.",
)  # fmt: skip
def command(wish: Wish) -> Wish:
    """Paint with textures: each region of TARGET is grown from the parts of the EXEMPLAR that carry its label.

    \b
    intarsia paint coast.png --labels coast_labels.png --target island.png -o island_grown.png
    intarsia paint --several sand.png moss.png -l sand_l.png -l moss_l.png -t map.png -o out.png
    """
    return wish
