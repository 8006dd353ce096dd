"""Maps that a surface lacks, proposed from those it has: height, normal and roughness of a photograph.

A photograph does not hold heights: these are proposals by plain means, and their planes say how (``meta["proposed"]``).
Heights are in shares of their range, black to white, which stands for `DEPTH` of the picture's shorter side.

Sources: Frankot and Chellappa, "A method for enforcing integrability in shape from shading algorithms", PAMI 1988
(heights by least squares in Fourier space); departure: the frequencies are those of central differences, of which the
normals are made, so that nothing but the finest checkerboard is lost. Heights of a photograph: no paper.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from numbers import Real

import numpy as np

from ..analysis.features import LUMINANCE
from ..analysis.illumination import flattened, illumination_of
from ..disk import check_fits
from ..foundation import STRENGTHS, InputError, ParameterError, called, expect, ndimage
from ..foundation.arrays import Array, Floats
from ..model import Exemplar
from ..model.image import EIGHT, Kind, Plane, Transfer, converted
from ..rendering import code_shares
from ..rendering.blending import NormalCoding
from ..search import elements

DEPTH = 1 / 32  # of the shorter side: by eye, on 46 photographs of 64 to 512 px, lit from the side
RELIEF = ((0.25, 0.0), (0.25, 1 / 512), (0.5, 1 / 256), (-1.0, 1 / 16))
"""Height of brightness: weights of Gaussians and their sigmas, in shares of the doubled picture's shorter side.

These are bands of an octave each, down to 1/8 of the picture; the two finest, mostly grain, count 1/4 and 1/2.
"""
JOINTS = ((1.0, 1 / 256), (-1.0, 1 / 32))  # the band in which joints are lines
FINE, AROUND = [(1.0, 1 / 256)], [(1.0, 1 / 128)]  # what is coarser than grain, and where its contrast is measured
NET, MORE, LIGHT = 0.5, 2.5, 0.6  # right for all 14 walls and floors; of 32 others it turns 5, a fence among them
STEEPEST = 0.05  # least z of a normal, 87 degrees: steeper ones are walls, or damaged
ROUGH, SMOOTHER, ROUGHER = 0.85, 0.4, 1.5  # by eye: of black, and what white and fine contrast change
MEMORY = 200  # bytes a px at most: six arrays of floats, twice as high and wide


def proposed(exemplar: Exemplar, *, strength: float = 1.0) -> Exemplar:
    """Return a material with the maps that it lacks proposed from those that it has.

    Of a photograph a strong slope of light is taken out; its height is the sum of six bands of its brightness, of octaves from 1/256
    to 1/8 of the shorter side: what is dark lies deep, unless what is light is a net that runs through, such as light
    joints between dark bricks. Its normals follow from the height; it is rough where it is dark and where its fine
    contrast is high. Of a height the normals are made, of normals the height, and nothing else.

    Parameters
    ----------
    exemplar : Exemplar
        A photograph, or a set that lacks maps. If it is toroidal the maps are, too, and its light stays.
    strength : float
        How steep the normals are, -100 to 100; default 1. Below 0 what lay deep stands out.

    Returns
    -------
    Exemplar
        With planes ``height``, ``normal`` (green up) and ``roughness`` more; heights of 16 bits, others of 8 if the
        photograph has no more.

    Raises
    ------
    InputError
        if there is nothing to propose, or nothing to propose it from.
    ParameterError
        for a wrong strength.
    """
    expect(exemplar, Exemplar, "the exemplar", "one of read(path) or Exemplar.of(array)", InputError)
    has, wrap, new = exemplar.planes, exemplar.toroidal, dict[str, Plane]()
    if "normal" in has and "height" not in has:
        new["height"] = height_of(has["normal"], wrap=wrap)
    elif "height" in has and "normal" not in has:
        new["normal"] = normal_of(has["height"], strength=strength, wrap=wrap)
    elif exemplar.base.kind is not Kind.COLOUR or {"normal", "roughness"} <= has.keys():
        raise InputError(f"{exemplar.name} lacks no map, or the picture to propose it from; give a photograph.")
    else:
        lone = len(has) == 1 and not wrap
        exemplar = flattened(exemplar) if lone and _has_a_slope_of_light(exemplar) else exemplar
        light, whole = _doubled(_brightness(exemplar.base), wrap), np.s_[: exemplar.height, : exemplar.width]
        if "normal" not in has:
            relief, deep = _filtered(light, RELIEF)[whole] * 65535, "dark"
            if _light_joints(light):
                relief, deep = -relief, "light"
            new["height"] = _plane(relief + 32768, Kind.DATA, f"bands of brightness, what is {deep} lies deep")
            new["normal"] = normal_of(new["height"], strength=strength, wrap=wrap)
            if strength < 0:
                new["height"] = new["height"].like(np.uint16(65535) - new["height"].samples)
        if "roughness" not in has:
            new["roughness"] = _plane(_roughness(light)[whole] * 65535, Kind.DATA, "rough where dark or uneven")
    if exemplar.base.pixels.dtype == EIGHT:
        for name in new.keys() - {"height"}:
            new[name] = new[name].like(converted(new[name].samples, "data", False, EIGHT))
    return replace(exemplar, planes={**exemplar.planes, **new})


def _has_a_slope_of_light(exemplar: Exemplar) -> bool:
    """Return whether light is uneven beyond chance: what is divided out otherwise is some of the texture."""
    return illumination_of(exemplar, float(elements(exemplar).size)).strong


def normal_of(height: Plane, *, strength: float = 1.0, wrap: bool = False) -> Plane:
    """Return the normals of a height map: green up, 16 bits, by central differences.

    Parameters
    ----------
    height : Plane
        Its first channel; black to white, or 0 to 1 of floats, stands for 1/32 of the shorter side.
    strength : float
        How many times steeper the normals are, -100 to 100; default 1.
    wrap : bool
        Whether the surface continues across its borders; else it is mirrored there.

    Returns
    -------
    Plane

    Raises
    ------
    InputError, ParameterError
        if the height is no plane, or the strength no number of the range.
    """
    expect(height, Plane, "the height", "a Plane", InputError)
    if isinstance(strength, bool) or not isinstance(strength, Real) or not abs(strength) <= STRENGTHS:
        raise ParameterError(f"strength={called(strength)} is not allowed; give -{STRENGTHS} to {STRENGTHS}.")
    rise = code_shares(height.samples[..., 0])
    rise *= strength * DEPTH * min(rise.shape) / max(float(np.ptp(rise)), 1.0)
    wide = np.pad(rise, 1, mode="wrap" if wrap else "symmetric")
    across, down = wide[1:-1, 2:] - wide[1:-1, :-2], wide[2:, 1:-1] - wide[:-2, 1:-1]
    vectors = np.stack([-across, down, np.full(rise.shape, 2.0)], axis=2)
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    return _plane((vectors + 1) * 32767.5, Kind.NORMAL, "slopes of the height")


def height_of(normal: Plane, *, wrap: bool = False) -> Plane:
    """Return the height map whose slopes come nearest to those of normals, 16 bits; its mean is lost, and its slope.

    Parameters
    ----------
    normal : Plane
        Normals; green points up unless ``meta["normals"]`` is "dx".
    wrap : bool
        Whether the surface continues across its borders; else it is mirrored there.

    Returns
    -------
    Plane
        Black to white is 1/32 of the shorter side, more only if the surface is taller.

    Raises
    ------
    InputError
        if these are no normals.
    """
    expect(normal, Plane, "the normals", "a Plane of three channels", InputError)
    if normal.kind is not Kind.NORMAL:
        raise InputError("the normals are a plane of another kind; give Plane(pixels, 'normal').")
    signed, down = normal.is_float and bool((normal.samples < 0).any()), normal.meta.get("normals") == "dx"
    coding = NormalCoding(normal.pixels.dtype, signed, down)
    x, y, z = np.moveaxis(np.nan_to_num(coding.vectors(normal.samples) / coding.top), 2, 0)
    z = np.maximum(z, STEEPEST)
    y = -y if down else y
    rise = _integral(_doubled(y / z, wrap, 0), _doubled(-x / z, wrap, 1))[: normal.height, : normal.width]
    for at in () if wrap else np.ogrid[: rise.shape[0], : rise.shape[1]]:
        far = at - at.mean()
        rise -= far * (far * rise).mean() / max(float((far**2).mean()), 1.0)
    rise -= (rise.max() + rise.min()) / 2
    rise /= max(float(np.ptp(rise)), DEPTH * min(rise.shape))
    return _plane(rise * 65535 + 32768, Kind.DATA, "fitted to the normals")


def _doubled(values: Floats, wrap: bool, odd: int | None = None) -> Floats:
    """Return a picture twice as high and wide that continues across its borders: repeated, or mirrored.

    Slopes along the axis `odd` change their sign in the mirror.
    """
    check_fits(MEMORY * values.size, "proposing maps", "crop or reduce the picture")
    for axis in (0, 1):
        more = values if wrap else np.flip(values, axis) * (-1 if axis == odd else 1)
        values = np.concatenate([values, more], axis)
    return values


def _frequencies(shape: tuple[int, ...]) -> tuple[Array, Array]:
    return 2 * np.pi * np.fft.fftfreq(shape[0])[:, None], 2 * np.pi * np.fft.rfftfreq(shape[1])


def _integral(down: Floats, across: Floats) -> Floats:
    """Return the surface whose central differences come nearest to slopes."""
    y, x = map(np.sin, _frequencies(down.shape))
    total = y**2 + x**2
    waves = (y * np.fft.rfft2(down) + x * np.fft.rfft2(across)) / np.where(total > 1e-9, total, np.inf)
    return np.fft.irfft2(-1j * waves, down.shape)


def _filtered(values: Floats, weights: Iterable[tuple[float, float]]) -> Floats:
    """Return a weighted sum of a picture blurred by Gaussians, whose sigmas are shares of the shorter side."""
    y, x = (along * min(values.shape) for along in _frequencies(values.shape))
    gain = sum(weight * np.exp(-(sigma**2) / 2 * (y**2 + x**2)) for weight, sigma in weights)
    return np.fft.irfft2(gain * np.fft.rfft2(values), values.shape)


def _light_joints(light: Floats) -> bool:
    """Return whether the lighter part of a picture is a net that runs through, and the darker part is none."""
    band, largest = _filtered(light, JOINTS), list[float]()
    for lines in (band > np.quantile(band, LIGHT), band < np.quantile(band, 1 - LIGHT)):
        sizes = np.bincount(ndimage.label(lines)[0].ravel(), minlength=2)[1:]
        largest.append(min(1.0, 4 * sizes.max() / max(1, sizes.sum())))  # the picture is there four times
    return bool(largest[0] >= NET and largest[0] > MORE * largest[1])


def _roughness(light: Floats) -> Floats:
    """Return 0 to 1: high where it is dark, and where fine contrast is high."""
    smooth = _filtered(light, FINE)
    contrast = np.sqrt(np.abs(_filtered((light - smooth) ** 2, AROUND)))
    return ROUGH - SMOOTHER * smooth + ROUGHER * contrast


def _brightness(base: Plane) -> Floats:
    """Return the mean of the sRGB codes of red, green and blue, 0 to 1, weighted by luminance."""
    codes = converted(base.samples, "colour", base.transfer is Transfer.LINEAR, np.dtype(np.uint16)) / 65535
    return codes[..., :3] @ LUMINANCE if base.channels >= 3 else codes[..., 0]


def _plane(codes: Floats, kind: Kind, how: str) -> Plane:
    """Return proposed values, in codes of 16 bits, rounded half up, as a plane that tells how they came about."""
    return Plane(np.clip(np.floor(codes + 0.5), 0, 65535).astype(np.uint16), kind, meta={"proposed": how})
