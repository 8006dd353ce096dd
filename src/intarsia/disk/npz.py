"""Saved maps: measured before they are unpacked, whatever their archive claims."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation import InputError, IntarsiaError, ParameterError, legible, printable
from . import check_cost, no_room
from .whole import ordinary

LONGEST = 1 << 24
"""Most bytes of what a map says of itself."""

MOST_SIDE, MOST_AREA = (1 << 31) - 1, 1 << 31
"""Most px of a map, and of the exemplars that it names, along a side and in all."""

_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}

Held = tuple[dict[str, NDArray[Any]], dict[str, Any]]


def packed(arrays: Mapping[str, Any]) -> bytes:
    """Return the content of a .npz: equal arrays give equal bytes.

    It is compressed as quickly as zlib can: a sixth larger, and in a tenth of the time.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.asanyarray(array), allow_pickle=False)
    return buffer.getvalue()


@contextmanager
def unpacked(path: str | Path, types: Mapping[str, Any]) -> Iterator[Held]:
    """Lend the arrays of a saved map and what it says of itself; whatever fails meanwhile is told in one line.

    Raises
    ------
    InputError
        where the file cannot be read or is no map, or would take much memory with next to nothing in it.
    ResourceError
        where it does not fit into memory.
    """

    name = printable(path)
    size = ordinary(Path(path), name, "a map saved with --save-map")
    try:
        with open(path, "rb") as file:
            with zipfile.ZipFile(file) as archive:
                cost = _measured(archive, types)
            check_cost(name, cost, size)
            file.seek(0)
            with np.load(file, allow_pickle=False) as data:
                about = json.loads(bytes(data["about"]))
                arrays = {k: data[k] for k in types if k in data}
        yield arrays, about
    except MemoryError:
        raise no_room(name) from None
    except OSError as e:
        reason = (e.strerror or legible(str(e))).lower()
        raise InputError(f"{name} cannot be read ({reason}); check the permissions, or copy it again.") from None
    except (InputError, ParameterError) as e:
        if str(e).startswith(name):
            raise
        raise _no_map(name, e) from None
    except Exception as e:  # a damaged archive can fail in any way
        raise _no_map(name, e) from None


def _no_map(name: str, e: Exception) -> InputError:
    why = str(e).rstrip(".") if isinstance(e, IntarsiaError) else type(e).__name__
    return InputError(f"{name} is no map of intarsia ({why}); give one saved with --save-map.")


def _measured(archive: zipfile.ZipFile, types: Mapping[str, Any]) -> int:
    """Return the bytes that the arrays will take, after a look at their headers; ValueError where they are no map's."""
    cost, held = 0, set(archive.namelist())
    if not {"yx.npy", "about.npy"} <= held:
        raise ValueError
    for name in ("about", *types):
        if name + ".npy" not in held:
            continue
        with archive.open(name + ".npy") as file:
            shape, _, dtype = _HEADERS[np.lib.format.read_magic(file)](file)
        area, sides = prod(shape), shape[:2]
        if name == "about":
            if area * dtype.itemsize > LONGEST:
                raise ValueError
        elif dtype != types[name] or not shape or min(sides) < 1 or max(sides) > MOST_SIDE or prod(sides) > MOST_AREA:
            raise ValueError
        cost += area * dtype.itemsize
    return cost


def check_sides(height: Any, width: Any) -> None:
    """Refuse what is no size of an exemplar."""
    if not all(type(side) is int and 0 < side <= MOST_SIDE for side in (height, width)) or height * width > MOST_AREA:
        raise ValueError
