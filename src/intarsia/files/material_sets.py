"""Material sets: files that share a name and differ by a known ending are maps of one surface."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ..disk import reason_of
from ..disk.atomic import PathLike
from ..foundation import MATERIALS, InputError, ParameterError, printable
from ..model.image import Plane
from .decode import opened
from .formats import LAYER, SUFFIXES, layer_of, open_picture, split_layer

Files = dict[str, PathLike]
"""The files of one exemplar: plane -> path."""

PLANE_WORDS = {
    "albedo": "basecolor basecolour base_color base_colour albedo diff diffuse col color colour",
    "normal": "normal normals nrm norm nor_gl normalgl normal_gl normal_ogl normal_opengl nrm_gl "
    "nor_dx normaldx normal_dx normal_directx nrm_dx",
    "roughness": "roughness rough",
    "metallic": "metallic metalness metal",
    "height": "height disp displacement bump",
    "ao": "ao ambientocclusion ambient_occlusion occlusion",
    "orm": "orm occlusionroughnessmetallic",
    "arm": "arm",
    "rma": "rma",
    "packed": "packed",
    "opacity": "opacity alpha",
    "emission": "emission emissive",
    "mask": "mask",
    "specular": "specular spec gloss",
}
"""The names of planes, in the order of a set, and the endings that mean them."""

_NAME = {word: name for name, words in PLANE_WORDS.items() for word in words.split()}
_CLEAR = frozenset(_NAME) - frozenset(
    [w for n in ("albedo", "arm", "packed", "opacity", "emission", "mask", "specular") for w in PLANE_WORDS[n].split()]
    + ["norm", "rough", "metal", "height", "disp", "bump", "occlusion"]
)
"""Words that mean a map even if the file is given alone; "old_metal.png" is a picture of metal."""
_DIRECTX = frozenset(["nor_dx", "normaldx", "normal_dx", "normal_directx", "nrm_dx"])
_KIND = re.compile(r"\d{1,2}k|(8|16|32)bit|png|jpg|jpeg|exr|tif|proposed", re.IGNORECASE)
_TAG = re.compile(rf"{_KIND.pattern}|\d{{3,5}}(x\d{{3,5}})?", re.IGNORECASE)  # a number within a name may be its own
PROPOSED = "_proposed"
"""Ending of the name of a map that was proposed, not measured."""

READABLE = frozenset([*SUFFIXES, ".gif", ".pnm"])


def group(paths: Iterable[PathLike], how: str = "auto") -> list[Files]:
    """Sort files into exemplars: one dict of plane name to path for each, the albedo first.

    ``auto``: files that share a stem are one set, different stems are several exemplars, a folder is one set.
    ``set``: all files are one set. ``several``: every file is an exemplar of its own.
    An EXR file alone whose layers are maps is a set. Any other file alone is a plain picture, unless its ending is
    unmistakable (``normal``, ``roughness``, ...).

    Raises InputError where two files are the same map, where several maps lack the picture that they belong to, and
    for a folder without pictures.
    """
    if how not in ("auto", "set", "several"):
        raise ParameterError(f"how={how} is not allowed; choose auto, set or several.")
    found: list[Files] = []
    loose: list[PathLike] = []
    for path in paths:
        if _is_folder(path) and how == "auto":
            found.append(_one_set(_pictures_in(path), printable(path), "-o FOLDER/ to work on each, --several to mix"))
        else:
            loose.extend(_pictures_in(path) if _is_folder(path) else [path])
    if how == "set":
        return [_one_set(loose, "the set")] if loose else []
    bases: dict[tuple[str, str], list[PathLike]] = {}
    for number, path in enumerate(loose):
        base = name_of(path)[0].lower()
        alone = how == "several" or _special(path)
        key = ("", str(number)) if alone else (os.path.dirname(os.fspath(path)), base)
        bases.setdefault(key, []).append(path)
    return found + [_one_set(files, name_of(files[0])[0]) for files in bases.values()]


class Material(NamedTuple):
    """The files of a material, its name, and its subfolder of the folder that was searched ("" at the top)."""

    name: str
    place: str
    files: list[PathLike]


def materials(folder: PathLike, how: str = "auto") -> list[Material]:
    """Find the materials of a folder and of all folders in it; :func:`group` with ``set`` makes a set of the files.

    ``auto``: the pictures of a folder are one set where no two of them hold the same plane, else those that share a
    stem are. ``several``: every picture is a material. What is hidden and links to folders are left out. InputError
    where no picture is found.
    """
    if how not in ("auto", "several"):
        raise ParameterError(f"how={how} is not allowed; choose auto or several.")
    found = []
    for at, below, names in os.walk(folder, onerror=_unlisted):
        below[:] = sorted(n for n in below if not n.startswith("."))
        place = "" if at == os.fspath(folder) else os.path.relpath(at, folder)
        paths = _readable(at, names)
        paths = paths if how == "several" else _without_previews(paths)
        lots: dict[str, list[PathLike]] = {}
        for path in paths:
            key = os.fspath(path) if how == "several" else name_of(path)[0].lower()
            lots.setdefault(key, []).append(path)
        planes = [{name_of(path)[1] or "albedo" for path in lot} for lot in lots.values()]
        if how == "auto" and len(lots) > 1 and sum(map(len, planes)) == len(set[str]().union(*planes)):
            lots = {"": paths}
        for lot in lots.values():
            own = name_of(lot[0])[0] if len(lot) > 1 else Path(lot[0]).stem
            name = place if place and len(lots) == 1 else "/".join(filter(None, (place, own)))
            found.append(Material(printable(name or Path(folder).name), place, lot))
    if not found:
        raise InputError(f"{printable(folder)} holds no picture; name another folder, or a file.")
    return found


def layered(path: PathLike) -> Files:
    """Return the set that the layers of an EXR file are, as FILE.exr::LAYER; so are a built-in material's maps.

    Empty for all other files.

    A picture without a name is the albedo, where no layer is called so. Raises InputError where two layers are the same
    map, or several maps lack their picture.
    """
    text = os.fspath(path)
    if planes := MATERIALS.get(text.removeprefix("sample:")) if text.startswith("sample:") else None:
        return {name: f"{text}{LAYER}{name}" for name in planes}
    found: dict[str, str] = {}
    layers = {} if _special(path) else layers_of(path)
    for layer in sorted(layers, key=lambda one: not one):
        name = _NAME.get(layer.rpartition(".")[2].lower())
        if not layer:
            name = "albedo" if {"R", "G", "B"} <= {c.upper() for c in layers[""]} else None
        if name is None or (not layer and name in found):
            continue
        if name in found:
            raise InputError(f"{printable(path)}: the layers {found[name]} and {layer} both are the {name}; keep one.")
        found[name] = layer
    if len(found.keys() - {"mask"}) < 2:
        return {}
    if "albedo" not in found:
        listed = " and ".join(found.values())
        raise InputError(f"{printable(path)}: {listed} are maps without the picture that they belong to; add a layer.")
    return {name: f"{os.fspath(path)}{LAYER}{found[name]}" for name in PLANE_WORDS if name in found}


def describe(sets: Iterable[Mapping[str, PathLike]]) -> str:
    """Describe in words how files were grouped, one line for each exemplar."""
    lines = []
    for number, files in enumerate(sets, 1):
        parts = [f"{name} {printable(Path(p).name)}" for name, p in files.items()]
        dx = any(name == "normal" and uses_directx(p) for name, p in files.items())
        what = f"one set of {len(parts)} maps" if len(parts) > 1 else "one picture"
        lines.append(f"exemplar {number}: {what}: {', '.join(parts)}{' (DirectX normals)' if dx else ''}")
    return "\n".join(lines)


def name_of(path: PathLike) -> tuple[str, str | None]:
    """Split a file name into the stem that it shares with its set, and the name of its plane (None: not stated)."""
    tokens, word = _split(path)
    return "_".join(tokens), None if word is None else _NAME[word]


def uses_directx(path: PathLike) -> bool:
    """Return whether the green axis of a normal map points down, as in DirectX, by its name."""
    return _split(path)[1] in _DIRECTX


def marks_of(path: PathLike) -> str:
    """Return what the name of a map says of it and has to say again in that of a map made of it."""
    proposed = Path(split_layer(path)[0]).stem.lower().endswith(PROPOSED)
    return "_dx" * uses_directx(path) + PROPOSED * proposed


def word_of(name: str, plane: Plane) -> str:
    """Return the ending of a file for a plane, from which its green axis and whether it is proposed are read again."""
    return name + "_dx" * (plane.meta.get("normals") == "dx") + PROPOSED * ("proposed" in plane.meta)


def _split(path: PathLike) -> tuple[list[str], str | None]:
    """Return the tokens of the stem without resolution tags and plane word, and that word."""
    stem = Path(split_layer(path)[0]).stem
    tokens = [t for t in re.split(r"[_\-. ]+", stem) if t]
    end = len(tokens)
    while end and _TAG.fullmatch(tokens[end - 1]):
        end -= 1
    for length in (2, 1):
        word = "_".join(tokens[max(0, end - length) : end]).lower()
        if end >= length and word in _NAME:
            return [t for t in tokens[: end - length] if not _KIND.fullmatch(t)], word
    return tokens, None


def _one_set(files: list[PathLike], owner: str, more: str = "ask for --several") -> Files:
    if len(files) == 1:
        if found := layered(files[0]):
            return found
        word = _split(files[0])[1]
        clear = word is not None and word in _CLEAR and not _special(files[0])
        return {_NAME[word] if word is not None and clear else "albedo": files[0]}
    named: Files = {}
    for path in files:
        name = name_of(path)[1] or "albedo"
        if name not in named:
            named[name] = path
        elif name == "normal" and uses_directx(path) != uses_directx(named[name]):
            named[name] = named[name] if uses_directx(path) else path  # both are there: take OpenGL
        else:
            first, second = printable(Path(named[name]).name), printable(Path(path).name)
            raise InputError(
                f"{first} and {second} both are the {name} of {printable(owner)}; give one, or {more}."
            )
    maps = [path for name, path in named.items() if name != "mask"]
    if "albedo" not in named and len(maps) > 1:
        listed = " and ".join(printable(Path(path).name) for path in maps)
        raise InputError(
            f"{listed} are maps without the picture that they belong to; add it, or give one of them alone and the "
            "others by --map NAME=FILE."
        )
    return {name: named[name] for name in PLANE_WORDS if name in named}


def _special(path: PathLike) -> bool:
    text = os.fspath(path)
    return text == "-" or text.startswith("sample:")


def _is_folder(path: PathLike) -> bool:
    return not _special(path) and os.path.isdir(path)


def _pictures_in(folder: PathLike) -> list[PathLike]:
    """Return the pictures in a folder, sorted; beside maps, files without a known ending are left out."""
    _, _, names = next(os.walk(folder, onerror=_unlisted))
    if not (paths := _readable(folder, names)):
        raise InputError(f"{printable(folder)} holds no picture; name another folder, or a file.")
    return _without_previews(paths)


def _unlisted(e: OSError) -> None:
    raise InputError(f"{printable(e.filename)} cannot be listed ({reason_of(e)}); check the permissions.")


def _readable(folder: PathLike, names: Iterable[str]) -> list[PathLike]:
    """Return the pictures among the names in a folder, sorted; hidden ones are left out."""
    kept = (n for n in sorted(names) if not n.startswith(".") and os.path.splitext(n)[1].lower() in READABLE)
    return [Path(folder, n) for n in kept]


def _without_previews(paths: list[PathLike]) -> list[PathLike]:
    """Leave out files without a known ending if others have one."""
    maps = [p for p in paths if name_of(p)[1] is not None]
    if not maps:
        return paths
    if any(name_of(p)[1] == "albedo" for p in maps):
        return maps
    bases = {name_of(p)[0].lower() for p in maps}
    return [p for p in paths if name_of(p)[0].lower() in bases]


def layers_of(path: PathLike) -> dict[str, list[str]]:
    """List the layers of an EXR file of one part, and the channels of each; ``""`` is the picture without a name.

    Empty for files that do not exist, that are no EXR, and that are damaged.
    """
    found: dict[str, list[str]] = {}
    if os.path.splitext(path)[1].lower() != ".exr" or not os.path.isfile(path):
        return found
    picture = open_picture(path)
    if picture.format == "exr":
        with suppress(InputError, ValueError), opened(picture) as (file, _):  # or names that are no UTF-8
            names = [] if file.seek_subimage(1, 0) else [str(name) for name in file.spec(0).channelnames]
            for name in sorted(names):
                found.setdefault(layer_of(name), []).append(name)
    return found
