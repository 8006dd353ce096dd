"""Fourier and cosine transforms: SciPy's, without what its package imports besides.

``import scipy.fft`` takes 0.13 s: tables of array libraries, special functions, texts of documentation. What computes
is one compiled module, which loads in 2 ms by its path. Where it lies elsewhere or is called otherwise, as it may in
another SciPy, the package is imported, and does the same. All functions mean what those of the same name in
``scipy.fft`` do, with the same bytes.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Axes = Sequence[int]

WHERE = "scipy.fft._pocketfft.pypocketfft"
FORWARD, INVERSE = {"forward": True, "inorm": 0}, {"forward": False, "inorm": 2}


class ByPackage:
    """The transforms by the public names of SciPy's package, called as its compiled module is."""

    def __init__(self) -> None:
        self._package: Any = import_module("scipy.fft")

    def good_size(self, target: int, real: bool) -> int:
        return int(self._package.next_fast_len(target, real))

    def r2c(self, a: Array, axes: Axes, forward: bool, inorm: int) -> Array:
        return np.asarray(self._package.rfftn(a, axes=axes))

    def c2r(self, a: Array, axes: Axes, lastsize: int, forward: bool, inorm: int) -> Array:
        size = [*(a.shape[axis] for axis in axes[:-1]), lastsize]
        return np.asarray(self._package.irfftn(a, size, axes=axes))

    def c2c(self, a: Array, axes: Axes, forward: bool, inorm: int, out: Array | None) -> Array:
        work = self._package.fftn if forward else self._package.ifftn
        return np.asarray(work(a, axes=axes, overwrite_x=out is not None))

    def dct(self, a: Array, type: int, axes: Axes, inorm: int, out: Array | None) -> Array:
        work = self._package.dctn if type == 2 else self._package.idctn
        return np.asarray(work(a, axes=axes))


def compiled(where: str = WHERE) -> Any:
    """Return SciPy's compiled transforms, or what stands for them where they cannot be had."""
    if where in sys.modules:
        return sys.modules[where]
    package, *inside, name = where.split(".")
    try:
        scipy = find_spec(package)
        homes = [Path(home, *inside) for home in (scipy and scipy.submodule_search_locations) or ()]
        path = next(p for home in homes for end in EXTENSION_SUFFIXES if (p := home / f"{name}{end}").exists())
        spec = spec_from_file_location(f"{__name__}.{name}", path)
        assert spec is not None
        assert spec.loader is not None
        found: Any = module_from_spec(spec)
        spec.loader.exec_module(found)
        one = found.r2c(np.zeros(4), axes=(0,), **FORWARD)
        found.c2c(one, axes=(0,), out=one, **FORWARD)
        found.c2r(one, axes=(0,), lastsize=4, **INVERSE)
        found.dct(np.zeros(4), 2, axes=(0,), inorm=0, out=None)
        found.good_size(7, True)
    except Exception:  # whatever another SciPy has there
        return ByPackage()
    return found


_core: Any = compiled()


@functools.cache
def next_fast_len(target: int, real: bool = False) -> int:
    """Return the least number not below `target` for which transforms are fast."""
    return int(_core.good_size(target, real))


def rfft(x: Array, n: int | None = None, axis: int = -1) -> Array:
    """Transform real lines, of `n` px: cut off, or continued with zeros."""
    return _real(x, None if n is None else (n,), (axis,))


def rfft2(x: Array, s: Sequence[int] | None = None) -> Array:
    """Transform real pictures, of the size `s`, in the last two axes."""
    return _real(x, s, (-2, -1))


def irfft(x: Array, n: int | None = None, axis: int = -1) -> Array:
    """Return the real lines of `n` px that have a transform."""
    return _back(x, None if n is None else (n,), (axis,))


def irfft2(x: Array, s: Sequence[int] | None = None) -> Array:
    """Return the real pictures of the size `s` that have a transform."""
    return _back(x, s, (-2, -1))


def fft(x: Array, n: int | None = None, axis: int = -1, overwrite_x: bool = False) -> Array:
    """Transform lines."""
    return _complex(x, None if n is None else (n,), (axis,), overwrite_x, FORWARD)


def ifft(x: Array, n: int | None = None, axis: int = -1, overwrite_x: bool = False) -> Array:
    """Return the lines that have a transform."""
    return _complex(x, None if n is None else (n,), (axis,), overwrite_x, INVERSE)


def fft2(x: Array, s: Sequence[int] | None = None) -> Array:
    """Transform pictures of the size `s`."""
    return _complex(x, s, (-2, -1), False, FORWARD)


def dctn(x: Array, axes: Axes | None = None) -> Array:
    """Return the cosine transform (of type 2), of all axes if none are named."""
    return _cosine(x, axes, 2, 0)


def idctn(x: Array, axes: Axes | None = None) -> Array:
    """Return what has a cosine transform."""
    return _cosine(x, axes, 3, 2)


def _real(x: Array, s: Sequence[int] | None, axes: Axes) -> Array:
    axes = [a % x.ndim for a in axes]
    return np.asarray(_core.r2c(_fitted(_floats(x), s, axes), axes=axes, **FORWARD))


def _back(x: Array, s: Sequence[int] | None, axes: Axes) -> Array:
    axes = [a % x.ndim for a in axes]
    *others, last = [x.shape[a] for a in axes[:-1]] + [2 * (x.shape[axes[-1]] - 1)] if s is None else s
    waves = _floats(x) if np.iscomplexobj(x) else _floats(x) + 0j
    return np.asarray(_core.c2r(_fitted(waves, (*others, last // 2 + 1), axes), axes=axes, lastsize=last, **INVERSE))


def _complex(x: Array, s: Sequence[int] | None, axes: Axes, spare: bool, way: dict[str, Any]) -> Array:
    axes = [a % x.ndim for a in axes]
    own = _fitted(_floats(x), s, axes)
    out = own if spare and own.dtype.kind == "c" else None
    return np.asarray(_core.c2c(own, axes=axes, out=out, **way))


def _cosine(x: Array, axes: Axes | None, type: int, norm: int) -> Array:
    return np.asarray(_core.dct(_floats(x), type, axes=range(x.ndim) if axes is None else axes, inorm=norm, out=None))


def _floats(x: Array) -> Array:
    """Numbers as the transforms take them."""
    if x.dtype.kind not in "fc":
        return x.astype(np.float64)
    return x.astype(np.float32) if x.dtype == np.float16 else x


def _fitted(x: Array, s: Sequence[int] | None, axes: Axes) -> Array:
    """Cut axes off at sizes, or continue them with zeros."""
    if s is None:
        return x
    size, where = list(x.shape), [slice(None)] * x.ndim
    for axis, n in zip(axes, s, strict=True):
        size[axis], where[axis] = int(n), slice(0, min(int(n), x.shape[axis]))
    part = x[tuple(where)]
    if list(part.shape) == size:
        return part
    whole = np.zeros(size, x.dtype)
    whole[tuple(where)] = part
    return whole
