"""Label pictures: every colour is a label, the same one in all pictures; stray colours of smoothed edges are told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import files
from ..errors import InputError, ParameterError
from ..exemplar import Exemplar
from ..guide import MAX_LABELS, Guide
from ..image import Array, Kind, Plane
from .adapt import adapted
from .exemplars import Shelf
from .request import Labels

RARE = 1000  # a colour on less than one in so many pixels is odd, unless it is common in another picture
SNAPPED = 200  # odd colours on less than one in so many pixels become their nearest label


@dataclass(frozen=True)
class _Picture:
    """A label picture: its file, the colours in it as numbers, which of them each pixel has, and how often."""

    path: str
    colours: Array
    at: Array
    counts: Array


def guide_of(labels: Labels, shelf: Shelf, lot: int, exemplars: Sequence[Exemplar]) -> Guide:
    """Read the label pictures of a lot of exemplars and the target, or refuse them in one line."""
    sources = labels.sources if len(shelf.lots) == 1 else labels.sources[lot : lot + 1]
    several = sum(len(found) for found in shelf.lots)
    if len(labels.sources) != several:
        raise ParameterError(
            f"--labels: {len(labels.sources)} given for {several} exemplar{'s' * (several > 1)}; "
            "give it once for each, in the same order."
        )
    planes = [files.read_plane(path, Kind.LABEL) for path in (*sources, labels.target)]
    for path, plane, found, e in zip(sources, planes, shelf.lots[lot], exemplars, strict=False):
        _check_size(path, plane, next(iter(found.values())), e, shelf)
    pictures = [_picture(path, plane) for path, plane in zip((*sources, labels.target), planes, strict=True)]
    names = _names(pictures)
    numbered = [_numbered(picture, names, shelf) for picture in pictures]
    _check_target(pictures, numbered, names)
    names_given = {"labels": tuple(map(_hex, names.tolist()))}
    made = [Plane(n, Kind.LABEL, meta=names_given) for n in numbered]
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


def _picture(path: str, plane: Plane) -> _Picture:
    """Pack the colours of a picture, red, green and blue of 16 bits each, into one number for each pixel."""
    samples = plane.samples
    if plane.is_float or samples.dtype == np.uint32:
        raise InputError(f"{path} has {samples.dtype} pixels; save labels with 8 or 16 bits a channel.")
    if samples.shape[2] in (2, 4):
        if (samples[:, :, -1] != samples[0, 0, -1]).any():
            raise InputError(f"{path} is partly transparent; save labels without opacity, one colour for each.")
        samples = samples[:, :, :-1]
    if samples.shape[2] not in (1, 3):
        raise InputError(f"{path} has {samples.shape[2]} channels; save labels as gray or colour.")
    wide = samples.astype(np.int64) * {"bool": 65535, "uint8": 257}.get(samples.dtype.name, 1)
    wide = np.broadcast_to(wide, (*wide.shape[:2], 3))
    packed = (wide[:, :, 0] << 32) | (wide[:, :, 1] << 16) | wide[:, :, 2]
    colours, at, counts = np.unique(packed, return_inverse=True, return_counts=True)
    return _Picture(path, colours, at.reshape(packed.shape), counts)


def _names(pictures: list[_Picture]) -> Array:
    """The colours that are labels: those that are common in one of the pictures, in their order."""
    names = np.unique(np.concatenate([p.colours[p.counts * RARE >= p.at.size] for p in pictures]))
    if len(names) > MAX_LABELS:
        most = max(pictures, key=lambda p: len(p.colours))
        raise InputError(
            f"{most.path} has {len(most.colours)} colours; save it without smoothed edges, "
            f"with one colour for each of at most {MAX_LABELS} labels."
        )
    return names


def _numbered(picture: _Picture, names: Array, shelf: Shelf) -> Array:
    """Number the labels; a few stray pixels become the label of the nearest colour."""
    odd = ~np.isin(picture.colours, names)
    stray = int(picture.counts[odd].sum())
    if stray * SNAPPED >= picture.at.size:
        raise InputError(
            f"{picture.path} has {int(odd.sum())} odd colours on {100 * stray / picture.at.size:.1f} % of its pixels; "
            "save it without smoothed edges, with one colour for each label."
        )
    if stray:
        shelf.warn(f"{picture.path}: {stray} px of {int(odd.sum())} odd colours were given the nearest label.")
    apart = ((_channels(picture.colours)[:, None] - _channels(names)[None]) ** 2).sum(axis=2)
    return np.asarray(apart.argmin(axis=1)[picture.at], np.uint8)


def _check_target(pictures: list[_Picture], numbered: list[Array], names: Array) -> None:
    there = set().union(*(np.unique(n).tolist() for n in numbered[:-1]))
    missing = sorted(set(np.unique(numbered[-1]).tolist()) - there)
    if missing:
        names_given = ", ".join(_hex(int(names[k])) for k in missing[:8])
        known = ", ".join(_hex(int(names[k])) for k in sorted(there)[:8])
        raise InputError(
            f"{pictures[-1].path} asks for {names_given}, which is in no label picture; "
            f"paint with {known}, or label it."
        )


def _channels(colours: Array) -> Array:
    return np.stack([colours >> 32, (colours >> 16) & 65535, colours & 65535], axis=1)


def _hex(colour: int) -> str:
    parts = [colour >> 32, (colour >> 16) & 65535, colour & 65535]
    if all(p % 257 == 0 for p in parts):
        return "#" + bytes(p // 257 for p in parts).hex()
    return "#" + "".join(f"{p:04x}" for p in parts)
