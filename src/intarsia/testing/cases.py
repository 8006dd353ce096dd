"""Test data for contract tests: small exemplars of all kinds, requests, and comparison of maps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt

from ..foundation.arrays import Array, Int32, Mask, Pair, UInt8
from ..foundation.geometry import Wrap
from ..foundation.run import Run
from ..methods import Ability, Method
from ..model import Exemplar, Exemplars
from ..model.image import Plane
from ..model.sourcemap import SourceMap
from ..synthesis import Synthesis, synthesize

DEPTHS = ("uint8", "uint16", "float32")
LONGEST = 45


def noise(height: int, width: int, seed: int) -> NDArray[np.uint64]:
    """Return 64 hashed bits for every pixel, the same on every machine."""
    y, x = np.mgrid[:height, :width].astype(np.uint64)
    z = np.uint64(seed % 2**32) << np.uint64(24)
    z = z + y * np.uint64(0x9E3779B97F4A7C15) + x * np.uint64(0xD1B54A32D192ED03)
    for factor in (0xBF58476D1CE4E5B9, 0x94D049BB133111EB):
        z = (z ^ (z >> np.uint64(29))) * np.uint64(factor)
    return np.asarray(z ^ (z >> np.uint64(32)), np.uint64)


def texture(height: int, width: int, channels: int = 1, seed: int = 0) -> UInt8:
    """Return a procedural texture (height, width, channels): soft blobs of some 6 px under a little noise.

    Made of integers only, so it is the same on every machine.
    """
    layers = []
    for c in range(channels):
        cells = (noise(height // 6 + 2, width // 6 + 2, seed * 97 + c) >> np.uint64(56)).astype(np.int64)
        (y, v), (x, u) = (divmod(np.arange(n), 6) for n in (height, width))
        top = cells[np.ix_(y, x)] * (6 - u) + cells[np.ix_(y, x + 1)] * u
        low = cells[np.ix_(y + 1, x)] * (6 - u) + cells[np.ix_(y + 1, x + 1)] * u
        soft = (top * (6 - v)[:, None] + low * v[:, None]) // 36
        grain = (noise(height, width, seed * 89 + c) % np.uint64(9)).astype(np.int64) - 4
        layers.append(np.clip(soft + grain, 0, 255))
    return np.stack(layers, axis=2).astype(np.uint8)


def as_depth(pixels: UInt8, dtype: str) -> Array:
    """Return 8-bit pixels in another depth: 16 bits times 257, floats over 255."""
    if dtype == "uint16":
        return pixels.astype(np.uint16) * np.uint16(257)
    return pixels if dtype == "uint8" else (pixels / 255).astype(dtype)


@st.composite
def exemplars(
    draw: DrawFn,
    dtype: str | None = None,
    channels: int | None = None,
    *,
    masks: bool = True,
    least: int = 20,
    most: int = 36,
) -> Exemplar:
    """Draw an exemplar: uint8, uint16 or float32, of 1 to 5 channels, sometimes masked, sometimes toroidal."""
    dtype = dtype or draw(st.sampled_from(DEPTHS))
    channels = channels or draw(st.integers(1, 5))
    height, width = draw(st.integers(least, most)), draw(st.integers(least, most))
    pixels = as_depth(texture(height, width, channels, draw(st.integers(0, 999))), dtype)
    usable = None
    if masks and draw(st.booleans()):
        usable = np.ones((height, width), bool)
        usable[: draw(st.integers(0, 2)), :] = False
        usable[:, width - draw(st.integers(1, 3)) :] = False
    return Exemplar.of(pixels, usable=usable, toroidal=draw(st.booleans()))


@dataclass(frozen=True)
class Case:
    """One request to a method."""

    exemplars: tuple[Exemplar, ...]
    size: Pair
    seed: int
    wrap: Wrap

    def grow(
        self, method: Method, *, start: SourceMap | None = None, seed: int | None = None, threads: int = 1
    ) -> Synthesis:
        """Run the method on the request, or on a start map, or with another seed."""
        return synthesize(
            self.exemplars,
            self.size,
            method,
            seed=self.seed if seed is None else seed,
            wrap=self.wrap,
            start=start,
            run=Run(threads),
        )

    def painted(self, plane: Callable[[int, Exemplar], Plane]) -> Case:
        """Return the request with other base planes, made from the number of an exemplar and the exemplar."""
        made = (Exemplar.of(plane(n, e), usable=e.usable, toroidal=e.toroidal) for n, e in enumerate(self.exemplars))
        return replace(self, exemplars=tuple(made))


@st.composite
def cases(draw: DrawFn, method: Method, *, least: int = 20) -> Case:
    """Draw a request that the method supports: several exemplars, masks and wraps only if it claims them."""
    supports = method.supports
    dtype, channels = draw(st.sampled_from(DEPTHS)), draw(st.integers(1, 5))
    count = draw(st.integers(1, 2)) if Ability.SEVERAL in supports else 1
    kind = exemplars(dtype, channels, masks=Ability.MASK in supports, least=least, most=least + 14)
    side = st.integers(1, LONGEST)
    return Case(
        tuple(draw(kind) for _ in range(count)),
        (draw(side), draw(side)),
        draw(st.integers(0, 2**64 - 1)),
        draw(st.sampled_from(list(Wrap))) if Ability.WRAP in supports else Wrap.NONE,
    )


def looked_up(exemplars: Exemplars, smap: SourceMap, plane: str | None = None) -> Array:
    """Return a map rendered by plain lookup, exemplar by exemplar: law 1."""
    planes = [e.base if plane is None else e.planes[plane] for e in exemplars]
    out = np.zeros((*smap.shape, planes[0].channels), planes[0].pixels.dtype)
    for number, p in enumerate(planes):
        mine = smap.numbers == number
        out[mine] = p.samples[smap.yx[mine, 0], smap.yx[mine, 1]]
    return out if planes[0].pixels.ndim == 3 else out[:, :, 0]


def same_map(a: SourceMap, b: SourceMap) -> bool:
    """Whether two maps show the same pixels in the same poses."""
    return a.digest == b.digest


def same_pixels(a: SourceMap, b: SourceMap, where: Mask) -> bool:
    """Whether two maps show the same exemplar pixels in the same poses wherever `where` is True."""
    pairs = ((a.yx, b.yx), (a.numbers, b.numbers), (a.turns, b.turns))
    return all(bool((one[where] == two[where]).all()) for one, two in pairs)


def depth(start: SourceMap, wrap: Wrap) -> Int32:
    """Return the Chebyshev distance of every pixel to the nearest hole."""
    known = ~start.holes
    if known.all():
        return np.full(known.shape, 1 << 20, np.int32)
    height, width = known.shape
    tops, lefts = (height if wrap.y else 0), (width if wrap.x else 0)
    around = np.pad(known, ((tops, tops), (lefts, lefts)), mode="wrap")
    far = distance_transform_cdt(around, metric="chessboard")
    return np.asarray(far[tops : tops + height, lefts : lefts + width], np.int32)


def laid_over(below: SourceMap, start: SourceMap) -> SourceMap:
    """Return `start` with its holes filled from another map."""
    holes = start.holes
    return replace(
        start,
        yx=np.where(holes[:, :, None], below.yx, start.yx),
        which=np.where(holes, below.numbers, start.numbers),
        pose=np.where(holes, below.turns, start.turns),
    )
