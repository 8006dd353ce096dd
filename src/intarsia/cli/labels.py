"""Label pictures as the command line names them: one beside each exemplar, cut and reduced as it is, and the target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .. import files
from ..errors import InputError
from ..exemplar import Exemplar
from ..guide import Guide, numbered
from ..image import Kind, Plane
from .adapt import adapted
from .exemplars import Shelf, check_each
from .request import Labels


def guide_of(labels: Labels, shelf: Shelf, lot: int, exemplars: Sequence[Exemplar]) -> Guide:
    """Read the label pictures of a lot of exemplars and the target, or refuse them in one line."""
    sources = labels.sources if len(shelf.lots) == 1 else labels.sources[lot : lot + 1]
    check_each("--labels", len(labels.sources), sum(map(len, shelf.lots)))
    planes = [files.read_plane(path, Kind.LABEL) for path in (*sources, labels.target)]
    for path, plane, found, e in zip(sources, planes, shelf.lots[lot], exemplars, strict=False):
        _check_size(path, plane, next(iter(found.values())), e, shelf)
    made = numbered(list(zip((*sources, labels.target), planes, strict=True)), shelf.warn)
    inputs = replace(shelf.inputs, avoid=None, toroidal=False)
    beside = [
        adapted(Exemplar.of({"labels": plane}, name=path), inputs, lambda line: None).base
        for path, plane in zip(sources, made, strict=False)
    ]
    return Guide(beside, made[-1], labels.weight, labels.reach)


def _check_size(path: str, plane: Plane, picture: str, exemplar: Exemplar, shelf: Shelf) -> None:
    size = (exemplar.width, exemplar.height)
    if shelf.inputs.crop is not None or shelf.inputs.scale != 1:
        whole = files.read_plane(picture)
        size = (whole.width, whole.height)
    if (plane.width, plane.height) != size:
        raise InputError(
            f"the labels {path} are {plane.width}x{plane.height} px, {picture} is {size[0]}x{size[1]}; make them equal."
        )
