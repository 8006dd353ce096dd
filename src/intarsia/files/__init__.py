"""Reading and writing of pictures and material sets; only this room knows file formats and their libraries.

Files become planes and exemplars; so do the built-in ones. Those are three CC0 photographs that scikit-image carries,
and four surfaces and a material painted by formula, which lie in the folder `painted`, wrap around, and are made by
``tools/make_samples.py`` of the repository.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..disk import allowing
from ..disk.atomic import PathLike, check_writable, write_bytes
from ..foundation import (
    ALPHAS,
    MATERIALS,
    PAINTED,
    PHOTOS,
    SAMPLES,
    InputError,
    ParameterError,
    channels_of,
    chosen,
    expect_path,
    printable,
    said,
)
from ..foundation.arrays import Mask
from ..model import KIND_OF_NAME, Exemplar, check_size, finite
from ..model.image import PACKED, PACKINGS, Kind, Plane, Transfer, unpacked
from .decode import decode
from .formats import LAYER, format_of, open_picture, split_layer
from .material_sets import PROPOSED, describe, group, layered, marks_of, materials, name_of, uses_directx
from .write import RECIPE, check_depth, check_layered, encode, preview, read_recipe, recipe_path, tiles, write

__all__ = [
    "RECIPE",
    "allowing",
    "check_depth",
    "check_layered",
    "check_writable",
    "describe",
    "encode",
    "format_of",
    "group",
    "materials",
    "preview",
    "read",
    "read_mask",
    "read_plane",
    "read_recipe",
    "read_set",
    "recipe_path",
    "sample",
    "sample_names",
    "tiles",
    "write",
    "write_bytes",
]


def read(
    path: PathLike, *, mask: PathLike | None = None, alpha: str = "auto", channels: str | None = None,
    weights: Mapping[str, float] | None = None, **planes: PathLike,
) -> Exemplar:  # fmt: skip
    """Read an exemplar from a picture, and further maps of the same surface if you name them.

    An EXR file whose layers are maps, such as albedo.R and normal.X, is a set by itself.

    ``read("moss.png", height="moss_height.exr", normal="moss_normal.png")``; ``read("sample:tiles")`` needs no file.

    Parameters
    ----------
    path : path or "sample:NAME"
        PNG, JPEG, TIFF, EXR, HDR, WebP, TGA, BMP, GIF, PPM, PGM or PFM, judged by content, in its full depth.
    mask : path, optional
        A picture of the same size: white where the exemplar may be used, black where not.
    alpha : "auto", "channel" or "mask"
        ``channel``: alpha is synthesised like a colour. ``mask``: pixels of at most half opacity are not used, and
        alpha is dropped. ``auto`` is ``mask`` where alpha is nowhere partial, somewhere 0, and opaque in over half
        of the picture, else ``channel``. Colours under alpha 0 stay as stored.
    channels : str, optional
        What the channels of a packed map hold whose name does not say it, as in
        ``read("moss.png", packed="moss_mix.png", channels="R=roughness,G=height")``.
    weights : dict of str to float, optional
        How much planes count in matching, as in :class:`Exemplar`: ``weights={"height": 0.5}``.
    **planes : paths
        Further maps; their names (normal, height, roughness, metallic, ao, opacity, ...) tell what they hold. Those of
        packed ones are orm, arm, rma and packed: each of their channels becomes a plane.

    Raises
    ------
    InputError
        where a file is missing, damaged, too large, or does not fit the others.
    """
    expect_path(path)
    given = (layered(path) or {"albedo": path}) | planes | ({} if mask is None else {"mask": mask})
    return read_set(given, alpha=alpha, channels=channels, weights=weights)


def read_set(
    files: Mapping[str, PathLike], *, alpha: str = "auto", unused: Callable[[Plane, str], Mask] | None = None,
    channels: str | None = None, weights: Mapping[str, float] | None = None,
) -> Exemplar:  # fmt: skip
    """Read an exemplar from a dict of files, as :func:`group` returns them; ``mask`` says which pixels are usable.

    `unused` gives the pixels (H, W) of a base plane and its name that are replaced anyway; they may be NaN.
    `channels` says what those of the packed map hold, and `weights` how much planes count, as in :func:`read`.
    """
    if not isinstance(alpha, str) or alpha not in ALPHAS:
        raise ParameterError(f"alpha={said(alpha)} is not allowed; choose one of {', '.join(ALPHAS)}.")
    for path in files.values():
        expect_path(path)
    paths = {name: p for name, p in files.items() if name != "mask"}
    if not paths:
        raise InputError("a mask alone is no exemplar; give a picture as well.")
    planes = _planes(paths, channels)
    first, path = next(iter(planes)), next(iter(paths.values()))
    planes[first], usable = _split_alpha(planes[first], alpha, printable(path))
    if "mask" in files:
        marked = read_mask(files["mask"], planes[first], printable(path))
        usable = marked if usable is None else usable & marked
    if unused is not None and not all(map(finite, planes.values())):
        kept = ~unused(planes[first], printable(path))
        usable = kept if usable is None else usable & kept
    return Exemplar(planes, usable, name=_exemplar_name(path, files), weights=weights or {})


def read_plane(path: PathLike | bytes, kind: Kind | str | None = None) -> Plane:
    """Read one picture, from a path, from bytes, or from the standard input ("-"), in its full depth.

    EXR, HDR, PFM and float TIFF are linear, all else is sRGB. An EXR gives its RGB(A) or Y(A), else its first layer;
    ``FILE.exr::NAME`` is the layer of that name.
    """
    if not isinstance(path, bytes):
        expect_path(path)
    if isinstance(path, str) and path.startswith(PREFIX):
        made = sample(path)
        return made if kind is None else replace(made, kind=chosen(Kind, "kind", kind))
    file, layer = (path, None) if isinstance(path, bytes) else split_layer(path)
    picture = open_picture(file)
    if layer is not None:
        picture = replace(picture, name=printable(path))
    found = decode(picture, layer)
    pixels, kind = found.pixels, Kind.COLOUR if kind is None else chosen(Kind, "kind", kind)
    if kind is Kind.NORMAL:
        pixels = _three_channels(pixels, picture.name)
    if pixels.dtype == np.uint32 and kind is not Kind.LABEL:
        raise InputError(f"{picture.name} holds 32-bit labels, not a picture; save it with 16 bit or float.")
    linear = pixels.dtype.kind == "f"
    meta = {"name": picture.format} | ({} if found.icc is None else {"icc": found.icc})
    try:
        return Plane(pixels, kind, Transfer.LINEAR if linear else Transfer.SRGB, meta)
    except InputError as e:
        raise InputError(f"{picture.name}: {e}") from None


def _planes(paths: Mapping[str, PathLike], channels: str | None) -> dict[str, Plane]:
    """Read the planes of a set; each channel of a packed map is one. InputError if two files hold the same plane."""
    order, mixed = None if channels is None else channels_of(channels), [n for n in paths if n in (*PACKINGS, PACKED)]
    if order is not None and len(mixed) != 1:
        held = ", ".join(printable(Path(paths[n]).name) for n in mixed or paths)
        raise ParameterError(
            f"--packed {channels} says what one packed map holds, and here {'are several' if mixed else 'is none'} "
            f"({held}); give one, as NAME_orm or --map packed=FILE."
        )
    planes: dict[str, Plane] = {}
    owners: dict[str, PathLike] = {}
    base: Plane | None = None
    for name, path in paths.items():
        plane = read_plane(path, KIND_OF_NAME.get(name, Kind.COLOUR))
        if name == "normal" and uses_directx(path):
            plane = replace(plane, meta=plane.meta | {"normals": "dx"})
        if PROPOSED in marks_of(path):
            plane = replace(plane, meta=plane.meta | {"proposed": "by its name"})
        more = unpacked(name, plane, order, printable(path)) if name in mixed else {name: plane}
        for twice in planes.keys() & more.keys():
            first = printable(owners[twice])
            raise InputError(f"{first} and {printable(path)} both hold the {twice}; give one of them.")
        for one in more.values():
            check_size(f"{printable(path)} ({name})", one, printable(next(iter(paths.values()))), base := base or one)
        planes |= more
        owners |= dict.fromkeys(more, path)
    return planes


def _exemplar_name(path: PathLike, files: Mapping[str, PathLike]) -> str:
    text = os.fspath(path)
    if text == "-":
        return "stdin"
    if text.startswith(PREFIX):
        whole = text.partition(LAYER)[0]
        return whole if layered(whole) == files else text
    return name_of(text)[0] or Path(split_layer(text)[0]).stem


def _three_channels(pixels: NDArray[np.generic], name: str) -> NDArray[np.generic]:
    """Return the three channels of a normal map; a constant alpha is dropped, InputError for any other number."""
    if pixels.ndim == 3 and pixels.shape[2] == 4 and (pixels[:, :, 3] == pixels[0, 0, 3]).all():
        return pixels[:, :, :3]
    if pixels.ndim != 3 or pixels.shape[2] != 3:
        channels = 1 if pixels.ndim == 2 else pixels.shape[2]
        raise InputError(f"{name} has {channels} channels; a normal map needs 3, so save it without the others.")
    return pixels


def _split_alpha(plane: Plane, alpha: str, name: str) -> tuple[Plane, Mask | None]:
    """Decide whether alpha is a channel or a mask; return the plane and its usable pixels (None: all)."""
    if not plane.alpha:
        if alpha == "mask":
            raise InputError(f"{name} has no alpha to serve as a mask; give a mask of its own, or leave --alpha away.")
        return plane, None
    opacity = plane.samples[:, :, -1]
    full = 1.0 if plane.is_float else float(np.iinfo(opacity.dtype).max)
    if alpha == "auto":
        solid = opacity == full
        clear = opacity == 0
        footprint = bool((solid | clear).all() and clear.any() and 2 * int(solid.sum()) > solid.size)
        alpha = "mask" if footprint else "channel"
    if alpha == "channel":
        return plane, None
    colour = plane.samples[:, :, :-1]
    return plane.like(colour) if colour.shape[2] > 1 else replace(plane, pixels=colour[:, :, 0]), opacity > full / 2


def read_mask(path: PathLike, base: Plane, name: str) -> Mask:
    """Read a mask as large as the plane `base` of `name`: True where it is lighter than half, and opaque.

    In files that hold only 0 and 1, every 1 is light.
    """
    plane = read_plane(path, Kind.LABEL)
    if (plane.height, plane.width) != (base.height, base.width):
        size = f"{plane.width}x{plane.height} px, {name} {base.width}x{base.height}"
        raise InputError(f"the mask {printable(path)} is {size}; make them equal.")
    values = plane.samples
    full = 1.0 if plane.is_float else float(np.iinfo(values.dtype).max)
    if not plane.is_float and int(values.max()) <= 1:
        full = 1.0
    light = values[:, :, :3] if plane.channels > 2 else values[:, :, :1]
    weights = np.array([0.2126, 0.7152, 0.0722] if light.shape[2] == 3 else [1.0])
    with np.errstate(invalid="ignore"):
        usable = (light.astype(np.float64) * weights).sum(axis=2) > full / 2
    if plane.channels in (2, 4):
        usable &= values[:, :, -1] > full / 2
    return np.asarray(usable, dtype=bool)


PREFIX = "sample:"
FOLDER = Path(__file__).with_name("painted")


def sample_names() -> list[str]:
    """List the built-in exemplars, as in ``sample:tiles``."""
    return [*SAMPLES]


def sample(name: str) -> Plane:
    """Return a built-in exemplar, of a material its albedo, or as ``setts::normal`` another map; nothing is downloaded.

    Raises InputError for an unknown name.
    """
    word, mark, plane = name.removeprefix(PREFIX).partition(LAYER)
    if planes := MATERIALS.get(word):
        plane = plane or planes[0]
        if plane not in planes:
            raise InputError(f"sample:{word} has no plane {plane[:40]!r}; its planes are {', '.join(planes)}.")
        return _painted(f"{word}_{plane}", KIND_OF_NAME.get(plane, Kind.COLOUR))
    word += mark + plane
    if word in PAINTED:
        return _painted(word, Kind.COLOUR)
    if word not in PHOTOS:
        raise InputError(f"there is no sample {word[:40]!r}; choose one of {', '.join(sample_names())}.")
    # Its files are read by their place: scikit-image itself is slow to import, and might try to download.
    found = importlib.util.find_spec("skimage")
    path = Path(found.origin or "").parent / "data" / f"{word}.png" if found else None
    if path is None or not path.is_file():
        raise InputError(f"this scikit-image carries no {word}.png; choose a painted one, such as sample:tiles.")
    return Plane(decode(open_picture(path)).pixels, meta={"name": "png"})


def _painted(stem: str, kind: Kind) -> Plane:
    """Read a file of the folder `painted`."""
    return Plane(decode(open_picture(FOLDER / f"{stem}.png")).pixels, kind, meta={"name": "sample"})
