"""The command that makes a picture again without choosing its method, for a shell."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..methods.base import Method, keeps_lattice
from ..params import parameters, words

if TYPE_CHECKING:
    from .exemplars import Set
    from .plan import Order
    from .request import Begin, Inputs, Loom, Targets, Wish

SIDES = ("left", "right", "top", "bottom")


def command_of(order: Order, method: Method, seed: int, inputs: Inputs, wish: Wish, targets: Targets) -> str:
    """Return the command that makes the picture of an order again with this method and seed."""
    begin, healed = wish.begin, wish.begin is not None and bool(wish.begin.holes)
    tiled = begin is not None and begin.border is not None
    begun = "heal" if healed else "tile" if tiled else "extend"
    verb = begun if begin is not None else "grow" if wish.labels is None else "paint"
    said = [verb, *pictures_of(order.sets[:1] if begin is not None else order.sets, "--usable" if healed else "--mask")]
    said += ["--several"] * (begin is None and len(order.sets) > 1)
    for donor in inputs.donors:
        said += ["--from", donor]
    said += inputs_of(inputs)
    if begin is not None:
        said += _begun(begin, order.lot)
    if wish.labels is not None:
        sources = wish.labels.sources
        for path in sources if len(sources) == len(order.sets) else sources[order.lot : order.lot + 1]:
            said += ["--labels", path]
        said += given(target=wish.labels.target, weight=wish.labels.weight, reach=wish.labels.reach)
    said += ["-o", next(iter(order.pictures.values()))]
    said += ["--size", "x".join(map(str, order.size))] * (verb == "grow")
    lattice = keeps_lattice(method)  # it was not repaired
    wrap = None if tiled or wish.wrap == "none" else wish.wrap
    meant = order.blend.finish if begin is None else ()  # evened out, as it was chosen
    joined = wish if wish.finish is not None or not meant else replace(wish, finish=meant)
    said += ["--seed", str(seed), *joining_options(joined), *given(wrap=wrap)]
    said += given(depth=targets.depth, repair=None if lattice else wish.repair or None)
    said += ["--layers"] * targets.layers + ["--force"] * targets.force
    always = ("tolerance",) if healed or tiled else ()  # heal has a usual one of its own
    return shlex.join(["intarsia", *said, "--method", method.slug, *options_of(method, wish.pictures, always)])


def replay_command_of(order: Order, inputs: Inputs, wish: Wish) -> str:
    """Return the command that makes the picture of an order again from its recipe: it continues a map."""
    assert wish.start is not None
    first, *further = pictures_of(order.sets[:1])
    said = ["replay", next(iter(order.pictures.values())), "-o", "again.png", "--exemplar", first, *further]
    for found in order.sets[1:]:
        said += ["--exemplar", next(iter(found.values()))]
    said += [w for name, path in wish.pictures.items() for w in ("--picture", f"{name}={path}")]
    return shlex.join(["intarsia", *said, *inputs_of(inputs), "--start", wish.start[0]])


def weave_command_of(method: Method, out: str, sets: Sequence[Set], inputs: Inputs, wish: Wish, loom: Loom) -> str:
    """Return the command that weaves the same texture with this method, and goes on with what is there."""
    assert wish.size is not None
    said = ["weave", *pictures_of(sets), *inputs_of(inputs), "-o", out, "--size", "x".join(map(str, wish.size))]
    said += ["--origin", ",".join(map(str, loom.origin))] * any(loom.origin)
    said += given(chunk=loom.chunk, executor=loom.executor, dask=loom.dask, seed=loom.seed) + joining_options(wish)
    return shlex.join(["intarsia", *said, "--method", method.slug, *options_of(method, wish.pictures)])


def pictures_of(sets: Sequence[Set], masked: str = "--mask") -> list[str]:
    """Return the arguments and options that name exemplars, their planes and their masks."""
    said = [next(iter(found.values())) for found in sets]
    for found in sets:
        for name, path in list(found.items())[1:]:
            said += [masked, path] if name == "mask" else ["--map", f"{name}={path}"]
    return said


def inputs_of(inputs: Inputs) -> list[str]:
    """Return the options on what of the exemplars is used."""
    said: list[str] = []
    for name, value in inputs.recipe().items():
        if isinstance(value, dict):
            said += [word for key, number in value.items() for word in ("--plane-weight", f"{key}={number}")]
        else:
            said += [f"--{name}"] if value is True else [f"--{name}", written(value)]
    return said


def joining_options(wish: Wish) -> list[str]:
    """Return the options on how pieces are joined, as far as they were given."""
    level = None if wish.finish is None else wish.finish[0].radius if wish.finish else 0
    return given(feather=wish.feather, mixing=wish.mixing, level=level)


def given(**values: Any) -> list[str]:
    """Return the options of these names, but for those without a value."""
    return [word for name, value in values.items() if value is not None for word in (f"--{name}", str(value))]


def options_of(method: Method, pictures: Mapping[str, str], always: tuple[str, ...] = ()) -> list[str]:
    """Return the options that give a method its parameters, but for those that are the usual ones.

    `pictures` names the files of those that are pictures; what stands in `always` is said in any case.
    """
    said: list[str] = []
    for p in parameters(method):
        value = getattr(method, p.name)
        if value != p.default or p.name in always:
            said += [f"--{p.name.replace('_', '-')}", pictures.get(p.name) or text_of(p.kind, value)]
    return said


def text_of(kind: str, value: Any) -> str:
    """Write a parameter as the command line reads it."""
    if kind == "extent":
        return words(value)
    if kind == "vectors":
        return " ".join(",".join(repr(float(n)) for n in v) for v in value)
    return written(value)


def written(value: Any) -> str:
    """Write a value for people: lists with commas, vectors with spaces between them."""
    if isinstance(value, (list, tuple)):
        if value and isinstance(value[0], (list, tuple)):
            return " ".join(",".join(f"{n:.6g}" for n in v) for v in value)
        return ",".join(str(v) for v in value)
    return str(value)


def _begun(begin: Begin, lot: int) -> list[str]:
    """Return the options on what the canvas begins with."""
    if begin.margins is not None:
        return [w for side, px in zip(SIDES, begin.margins, strict=True) if px for w in (f"--{side}", str(px))]
    if (border := begin.border) is not None:
        size = None if border.size is None else "x".join(map(str, border.size))
        return given(axes=border.axes, band=border.band, size=size)
    said = ["--mask", begin.holes[lot if len(begin.holes) > 1 else 0]]
    said += given(grow=begin.grow)
    return said + ["--edge", str(begin.edge)] * (begin.edge != 0)
