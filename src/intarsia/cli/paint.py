"""``intarsia paint``: a texture whose regions are where you paint them. Imports nothing heavy before the work."""

from __future__ import annotations

from typing import Any

import click

from ..auto import AUTO_METHOD
from ..errors import ParameterError
from ..methods.base import METHODS, Ability, method_class
from .choosing import chosen_of
from .grow import OWN as GROWN
from .grow import SAMPLES, check_stdout, finish_of
from .options import (
    FILE,
    common,
    gathered,
    grown_target_options,
    input_options,
    method_option,
    method_parameters,
    opt,
    report_options,
)
from .pictures import named_pictures
from .report import Report
from .request import Inputs, Labels, Targets, Wish
from .values import Number, Seed, Seeds

GUIDED = tuple(slug for slug in METHODS if Ability.GUIDE in method_class(slug).supports)

OWN = (
    opt(
        "labels", "--labels", "-l", multiple=True, required=True, type=FILE, metavar="FILE",
        help="Which pixel of the exemplar is what: one colour for each label; once for each exemplar.",
    ),
    opt(
        "target", "--target", "-t", required=True, type=FILE, metavar="FILE",
        help="Where each label shall be, in the same colours; the output has its size.",
    ),
    opt(
        "weight", "--weight", type=Number(0, 100), default=2.0, show_default=True,
        help="How closely boundaries follow the target: 1.5 to 2.5 mostly; 0 takes what joins best.",
    ),
    opt(
        "reach", "--reach", type=click.IntRange(0, 256), default=0, show_default=True, metavar="PX",
        help="Pixels this near to a boundary count as partly of both labels.",
    ),
    opt(
        "method", "--method", "-m", type=click.Choice([AUTO_METHOD, *GUIDED]), default=AUTO_METHOD,
        show_default=True,
        help="How to grow; `intarsia methods` tells of each.",
    ),
    *(o for o in GROWN if o.field in ("wrap", "feather", "mixing", "level", "repair")),
)  # fmt: skip

UNION = {
    name: (p, [slug for slug in owners if slug in GUIDED])
    for name, (p, owners) in method_parameters({o.field for o in OWN}).items()
    if any(slug in GUIDED for slug in owners)
}
PARAMETERS = tuple(method_option(p, owners, len(owners) == len(GUIDED)) for p, owners in UNION.values())


def _wish(method: str, labels: tuple[str, ...], target: str, **given: Any) -> Wish:
    told = Labels(labels, target, given.pop("weight"), given.pop("reach"))
    wrap, feather, mixing = given.pop("wrap"), given.pop("feather"), given.pop("mixing")
    finish, repair = finish_of(given.pop("level")), given.pop("repair")
    pictures = named_pictures(given, (p for p, _ in UNION.values()))
    chosen = chosen_of(method, None, given, UNION)
    return Wish(
        chosen, None, wrap, feather, mixing, labels=told, finish=finish, repair=repair, pictures=pictures
    )  # fmt: skip


@click.command(
    name="paint",
    epilog=f"Built-in exemplars: {', '.join('sample:' + s for s in SAMPLES)}. OUT may hold {{seed}}, {{method}}, "
    "{w} and {h}; with --seeds every seed makes an output.",
)
@gathered(*OWN, *PARAMETERS, into="wish", make=_wish)
@click.option("--seed", type=Seed(), metavar="N|random", help="The same number gives the same picture. Default: 0.")
@click.option(
    "--seeds", type=Seeds(), metavar="1..9|1,4,7", help="A batch, one output for each seed; put {seed} into -o."
)
@grown_target_options
@input_options(opt("files", nargs=-1, required=True, type=FILE, metavar="EXEMPLAR..."))
@click.option("--dry-run", is_flag=True, help="Check everything, tell sizes and memory, write nothing.")
@common
@report_options
def command(
    inputs: Inputs,
    targets: Targets,
    wish: Wish,
    report: Report,
    seed: int | None,
    seeds: tuple[int, ...] | None,
    threads: int | None,
    dry_run: bool,
) -> None:
    """Paint with textures: each region of TARGET is grown from the parts of the EXEMPLAR that carry its label.

    \b
    intarsia paint coast.png --labels coast_labels.png --target island.png -o island_grown.png
    intarsia paint --several sand.png moss.png -l sand_l.png -l moss_l.png -t map.png -o out.png
    """
    if seed is not None and seeds is not None:
        raise ParameterError("--seed and --seeds exclude each other; drop one.")
    check_stdout(targets, report)
    if seeds is not None and "{seed}" not in targets.out:
        raise ParameterError(f"-o {targets.out}: all seeds would write one file; put {{seed}} into the name.")

    from .batch import Batch

    batch = Batch.plan(inputs, targets, wish, seeds if seeds is not None else (seed or 0,), report)
    if dry_run:
        batch.tell_plan()
    else:
        batch.carry_out(threads)
