"""Material sets as engines read them: their names of files, the green axis of their normals, and their packed maps.

Source: the manuals of Unreal 5, Unity 6 (HDRP), Godot 4 and Blender 4, and the specification of glTF 2.0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..foundation import CHANNELS, ENGINES, InputError, ParameterError, called, expect
from ..model import Exemplar
from ..model.image import Kind, Plane, converted
from ..rendering import enlarged

USUAL = {"ao": 1, "roughness": 1, "metallic": 0, "detail": 1, "smoothness": 0}
"""What a channel of a packed map is where its plane is missing: open, matt, no metal, full detail."""

ORM = ("ao", "roughness", "metallic")


class Wants(NamedTuple):
    """What an engine wants of a material."""

    hint: str  # its name, and what to do there
    words: Mapping[str, str]  # plane -> what it is called, where not by its own name
    pack: str  # what the packed map is called
    order: tuple[str, ...]  # its channels; none: nothing is packed


WANTS = {
    "unreal": Wants(
        "Unreal: switch sRGB off for ORM and H",
        {"albedo": "BC", "normal": "N", "height": "H", "opacity": "O", "emission": "E"}, "ORM", ORM,
    ),
    "unity": Wants(
        "Unity: MaskMap is that of HDRP; in URP it is the metallic and the occlusion map; switch sRGB off for it",
        {"albedo": "BaseMap", "normal": "Normal", "height": "Height", "emission": "Emission"},
        "MaskMap", ("metallic", "ao", "detail", "smoothness"),
    ),
    "godot": Wants("Godot: orm is for an ORMMaterial3D", {}, "orm", ORM),
    "blender": Wants("Blender: set all but base_color to Non-Color", {"albedo": "base_color"}, "", ()),
    "gltf": Wants(
        "glTF: the packed map is occlusionTexture and metallicRoughnessTexture; only PNG is read",
        {"albedo": "baseColor", "emission": "emissive"}, "occlusionRoughnessMetallic", ORM,
    ),
}  # fmt: skip


def for_engine(exemplar: Exemplar, engine: str) -> tuple[dict[str, Plane], list[str]]:
    """Return a material as an engine reads it: names of files, green of the normals, packed maps.

    ``pictures, told = ia.for_engine(stones, "unreal")``, then ``ia.write(folder / name, picture)`` for each.

    Parameters
    ----------
    exemplar : Exemplar
        A set, or a picture alone; files are called after its name.
    engine : {"unreal", "unity", "godot", "blender", "gltf"}
        Unreal reads DirectX normals, green down; the others OpenGL, green up.

    Returns
    -------
    dict of str to Plane
        Name of a file -> what is in it: PNG, or EXR for floats, in the depth of the planes. A packed map has the
        largest depth and size among its own; planes that are neither packed nor turned are those of the set.
    list of str
        What was turned, packed, or is missing, a line each.

    Raises
    ------
    ParameterError
        for another engine.
    """
    expect(exemplar, Exemplar, "the exemplar", "one of read(path) or Exemplar.of(array)", InputError)
    if not isinstance(engine, str) or engine not in ENGINES:
        raise ParameterError(f"engine={called(engine)} is not allowed; choose one of {', '.join(ENGINES)}.")
    wants, planes, told = WANTS[engine], dict(exemplar.planes), list[str]()
    guessed = [n for n, plane in planes.items() if "proposed" in plane.meta]
    missing = [n for n in ("normal", "height", *ORM) if n not in planes]
    way, reads = ("dx", "DirectX") if engine == "unreal" else ("gl", "OpenGL")
    if "normal" in planes and planes["normal"].meta.get("normals", "gl") != way:
        planes["normal"] = turned(planes["normal"], way)
        told.append(f"green of the normals was turned: {wants.hint.partition(':')[0]} reads {reads}")
    if "smoothness" in wants.order and "roughness" in planes:
        rough = planes.pop("roughness")
        planes["smoothness"] = rough.like(_top(rough.pixels.dtype) - rough.samples)
        told.append("roughness became smoothness: white minus it")
    if own := {n: planes.pop(n) for n in wants.order if n in planes}:
        planes[wants.pack] = _packed(own, wants.order)
        channels = ", ".join(map(" ".join, zip(CHANNELS, wants.order, strict=False)))
        told.append(f"{wants.pack} holds {channels}; without a map metallic and smoothness are black, others white")
    told += [f"missing: {', '.join(missing)}"] * bool(missing)
    told += [f"proposed, not measured: {', '.join(guessed)}"] * bool(guessed)
    stem = "T_" * (engine == "unreal") + exemplar.name.rpartition(":")[2]
    named = {f"{stem}_{wants.words.get(n, n)}.{'exr' if p.is_float else 'png'}": p for n, p in planes.items()}
    return named, [*told, wants.hint]


def turned(normal: Plane, way: str) -> Plane:
    """Return normals with green the other way, exactly: 255 - g, 65535 - g, 1 - g, or -g of floats with a sign.

    `way`: "dx" or "gl", which they then are.
    """
    codes = normal.samples.copy()
    codes[..., 1] = (0 if normal.is_float and (codes < 0).any() else _top(codes.dtype)) - codes[..., 1]
    return replace(normal, pixels=codes, meta=normal.meta | {"normals": way})


def _top(dtype: np.dtype[Any]) -> int:
    """Return the code of white."""
    return 1 if dtype.kind == "f" else np.iinfo(dtype).max


def _packed(own: Mapping[str, Plane], order: tuple[str, ...]) -> Plane:
    """Return one plane of a channel each, in the largest depth and size among those that are there."""
    dtype, shape = np.result_type(*(p.pixels.dtype for p in own.values())), max(p.shape for p in own.values())
    out = np.empty((*shape, len(order)), dtype)
    for k, n in enumerate(order):
        out[..., k] = USUAL[n] * _top(dtype)
        if n in own:
            codes = converted(own[n].samples, "data", False, dtype)
            out[..., k] = enlarged(codes, shape[0] // own[n].height)[..., 0]
    return Plane(out, Kind.DATA)
