"""Data model of a synthesis: planes, exemplars, canvas, guide, and source map.

This module holds the exemplar: aligned planes of one surface, a mask of usable pixels, and cached measurements.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..foundation import PLANE_WEIGHTS, SCALARS, InputError, ParameterError, called, expect, said
from ..foundation.arrays import Mask, Pair, marks, masked_pixels, pixels_of
from ..foundation.geometry import Shaped
from .image import PACKED, PACKINGS, Kind, Plane, packed, packs_of, unpacked
from .sourcemap import Source

T = TypeVar("T")

KIND_OF_NAME = {
    "normal": Kind.NORMAL,
    **dict.fromkeys(("height", "roughness", "metallic", "ao", "opacity", "specular", *PACKINGS, PACKED), Kind.DATA),
    **dict.fromkeys(("label", "labels", "id", "ids"), Kind.LABEL),
}
"""Kind of a plane by its name; any other name is a colour."""

REDUCED = "(reduced)"
"""Name of the first plane of a magnified exemplar: its base at reduced size, compared and never written."""


class NotFiniteError(InputError):
    """Usable pixels are NaN or infinite."""


@dataclass(frozen=True, eq=False)
class Exemplar(Shaped):
    """An example of a texture: one or more aligned planes.

    Parameters
    ----------
    planes : dict of str to Plane
        The first plane is the base, which sets the size (H, W). The others have its size, or a whole multiple of it,
        or a whole fraction.
    usable : bool array, shape (H, W), optional
        False where pixels must not be sampled. None, the default: all may be. A mask without usable pixels is allowed,
        as a start map may still point into such a picture.
    toroidal : bool
        True if the exemplar is periodic across its borders, default False.
    name : str
        A short name, for messages and maps, default "exemplar".
    weights : dict of str to float
        Weights of planes in matching, 0 to 100; default 1 each, but 0 for maps that were proposed from the others,
        which tell nothing that those do not. A plane of weight 0 is rendered, but not compared. The name of a packed
        map stands for all planes in it.

    Raises
    ------
    InputError
        if there is no plane, sizes do not fit, or a usable pixel is NaN or infinite.
    ParameterError
        for weights of unknown planes, or that leave nothing to compare.
    """

    planes: Mapping[str, Plane]
    usable: Mask | None = None
    toroidal: bool = False
    name: str = "exemplar"
    weights: Mapping[str, float] = field(default_factory=dict)
    _memo: dict[Any, Any] = field(default_factory=dict, repr=False, init=False)

    def __post_init__(self) -> None:
        expect(self.planes, Mapping, "planes", "planes by name, or make an exemplar with Exemplar.of", InputError)
        if not self.planes:
            raise InputError("an exemplar needs at least one plane.")
        for name, plane in self.planes.items():
            expect(plane, Plane, f"the plane {name}", "a Plane, or make an exemplar with Exemplar.of", InputError)
        expect(self.name, str, "name", "a word")
        expect(self.toroidal, (bool, np.bool_), "toroidal", "True or False")
        object.__setattr__(self, "toroidal", bool(self.toroidal))
        object.__setattr__(self, "planes", dict(self.planes))
        for name, plane in self.planes.items():
            check_size(f"the plane {name}", plane, "the base", self.base)
        if self.usable is not None:
            usable = marks(self.usable, "the mask")
            if usable.shape != self.shape:
                raise InputError(
                    f"the mask is {usable.shape[1]}x{usable.shape[0]} px, the exemplar "
                    f"{self.width}x{self.height}; make them equal."
                )
            usable.flags.writeable = False
            object.__setattr__(self, "usable", None if usable.all() else usable)
        for name, plane in self.planes.items():
            self._check_finite(name, plane)
        self._check_weights()

    @classmethod
    def of(
        cls, pixels: ArrayLike | Plane | Mapping[str, ArrayLike | Plane] | Exemplar, *, usable: ArrayLike | None = None,
        toroidal: bool | None = None, name: str | None = None, weights: Mapping[str, float] | None = None,
    ) -> Exemplar:  # fmt: skip
        """Make an exemplar of an array, a plane, or a dict of them.

        Parameters
        ----------
        pixels : array (H, W) or (H, W, C), Pillow image, Plane, dict of them by name, or Exemplar
            Names such as ``normal``, ``height`` or ``labels`` give the kind of a plane, any other name is a colour.
            Planes named ``orm``, ``arm`` or ``rma`` are unpacked into planes of one channel; ``render("orm")`` renders
            them as one. Pillow images are taken as Pillow displays them. Masked pixels of a masked array are not
            usable. Of an exemplar a copy with the given fields is returned, and masks are combined.
        usable, toroidal, name, weights : optional
            As of the class.

        Returns
        -------
        Exemplar

        Raises
        ------
        InputError, ParameterError
            as of the class; InputError also for what is no picture.
        """
        mask = None if usable is None else marks(usable, "the mask")
        if isinstance(pixels, Exemplar):
            mask = mask if pixels.usable is None or mask is None else _both(mask, pixels.usable)
            about: dict[str, Any] = {"usable": mask, "toroidal": toroidal, "name": name, "weights": weights}
            about = {key: value for key, value in about.items() if value is not None}
            return replace(pixels, **about) if about else pixels
        given = pixels if isinstance(pixels, Mapping) else {"albedo": pixels}
        planes: dict[str, Plane] = {}
        for n, p in given.items():
            made = _plane(n, p)
            more = unpacked(n, made) if n in PACKINGS and made.channels > 2 else {n: made}
            if twice := planes.keys() & more.keys():
                raise InputError(f"the packed map {n} holds {min(twice)}, which is given beside it; give one of them.")
            planes |= more
        for p in given.values():
            masked = masked_pixels(p)
            if masked is not None:
                base = next(iter(planes.values()))
                left = ~resized(masked, base.shape)
                mask = left if mask is None else _both(mask, left)
        name = "exemplar" if name is None else name
        return cls(planes, mask, toroidal is not None and toroidal, name, {} if weights is None else weights)

    def __repr__(self) -> str:
        return f"<exemplar {self.name}: {self.width}x{self.height} px, {', '.join(self.planes)}>"

    @property
    def base(self) -> Plane:
        """The plane that sets the size."""
        return next(iter(self.planes.values()))

    @property
    def drawn(self) -> tuple[str, ...]:
        """The names of the planes that are rendered: all but the reduced one of a magnified exemplar."""
        names = tuple(self.planes)
        return names[1:] if names[0] == REDUCED and len(names) > 1 else names

    @property
    def packs(self) -> dict[str, tuple[str, ...]]:
        """The names of packed maps -> the names of their planes, channel by channel."""
        return packs_of({name: self.planes[name] for name in self.drawn})

    @property
    def pictures(self) -> tuple[str, ...]:
        """The names of the pictures that are written: the rendered planes, those of a packed map as one."""
        packs = self.packs
        owner = {plane: pack for pack, own in packs.items() for plane in own}
        return tuple(dict.fromkeys(owner.get(name, name) for name in self.drawn))

    def picture(self, name: str) -> Plane | None:
        """Return the plane or the packed map of this name as one plane; None if there is neither."""
        if name in self.planes:
            return self.planes[name]
        own = self.packs.get(name)
        return None if own is None else self.memo(("packed", name), lambda: packed([self.planes[n] for n in own]))

    @property
    def compared(self) -> tuple[str, ...]:
        """The names of the planes that are compared in matching: the first, and others of a weight above 0.

        Of a magnified exemplar the reduced plane replaces the one that it was made from.
        """
        first, *others = self.planes if self.drawn == tuple(self.planes) else (REDUCED, *self.drawn[1:])
        return (first, *(name for name in others if self.weight(name)))

    def weight(self, name: str) -> float:
        """Return the weight of a plane in matching; by default 1, and 0 for unnamed channels of packed maps."""
        name = self.drawn[0] if name == REDUCED else name
        usual = 0.0 if PACKED in self.planes[name].meta and name not in SCALARS else 1.0
        return self.weights.get(name, usual)

    @property
    def times(self) -> int:
        """Magnification: how many times larger than the map the pictures are; 1 unless the exemplar is magnified."""
        return 1 if REDUCED not in self.planes else max(self.planes[self.drawn[0]].height // self.height, 1)

    @property
    def height(self) -> int:
        """Rows of the base plane."""
        return self.base.height

    @property
    def width(self) -> int:
        """Columns of the base plane."""
        return self.base.width

    @property
    def free(self) -> Mask:
        """The mask of usable pixels (H, W), also if all are usable."""
        return np.ones(self.shape, bool) if self.usable is None else np.asarray(self.usable)

    @property
    def source(self) -> Source:
        """The entry of this exemplar in a source map."""
        return Source(self.name, *self.shape, self.digest)

    @property
    def digest(self) -> str:
        """SHA-256 of everything that affects a result, as 64 hexadecimal digits."""
        return self.memo("digest", self._digest)

    def memo(self, key: Any, make: Callable[[], T]) -> T:
        """Return the value cached under `key`; computed at the first call."""
        if key not in self._memo:
            self._memo[key] = make()
        value: T = self._memo[key]
        return value

    def latest(self, name: str, key: Any, make: Callable[[], T]) -> T:
        """Return the value of the single-slot cache `name` if it was made for `key`; else compute and replace it."""
        found = self._memo.get(name)
        if found is None or found[0] != key:
            found = self._memo[name] = key, make()
        value: T = found[1]
        return value

    def _digest(self) -> str:
        h = hashlib.sha256()
        for name, plane in self.planes.items():
            plane.hashed(h, name)
        h.update(b"mask" + (b"" if self.usable is None else np.packbits(self.usable).tobytes()))
        h.update(b"toroidal" if self.toroidal else b"")
        if self.weights:
            h.update(b"weights" + repr(sorted(self.weights.items())).encode())
        return h.hexdigest()

    def _check_weights(self) -> None:
        """Normalise the weights to single planes, without those that are the default."""
        expect(self.weights, Mapping, "weights", "a number for each name of a plane")
        guesses = [name for name in self.drawn[1:] if "proposed" in self.planes[name].meta]
        packs, weights = self.packs, dict.fromkeys(guesses, 0.0)
        for name, weight in self.weights.items():
            own = packs.get(name, (name,))
            if name not in packs and name not in self.drawn:
                known = ", ".join((*self.drawn, *packs))
                raise ParameterError(f"weight {said(name)}: {self.name} has no such plane; choose one of {known}.")
            real = isinstance(weight, Real) and not isinstance(weight, bool)
            if not real or not 0 <= weight <= PLANE_WEIGHTS:
                raise ParameterError(f"weight {name}={called(weight)} is not allowed; give 0 to {PLANE_WEIGHTS}.")
            weights |= dict.fromkeys(own, float(weight))
        for name in [n for n in weights if PACKED not in self.planes[n].meta or n in SCALARS]:
            if weights[name] == 1 and name not in guesses:
                del weights[name]
        object.__setattr__(self, "weights", weights)
        if not any(self.weight(name) for name in self.compared):
            raise ParameterError(f"the weights leave no plane of {self.name} to compare; let one count.")

    def _check_finite(self, name: str, plane: Plane) -> None:
        if finite(plane):
            return
        bad = ~np.isfinite(plane.samples).all(axis=2)
        if self.usable is not None:
            bad &= resized(self.usable, plane.shape)
        if bad.any():
            raise NotFiniteError(
                f"{int(bad.sum())} pixels of the plane {name} are NaN or infinite; "
                "repair them, or leave them out (--mask; when healing, --usable; in Python, usable=)."
            )


Exemplars = Sequence[Exemplar]


def check_size(name: str, plane: Plane, first: str, base: Plane) -> None:
    """Raise InputError if the size of a plane does not fit that of the base; `name`, `first`: names in messages."""
    size, other = f"{plane.width}x{plane.height} px", f"{base.width}x{base.height}"
    if plane.height * base.width != plane.width * base.height:
        raise InputError(f"{name} is {size}, of another shape than {first} ({other}); scale both axes alike.")
    if max(plane.height, base.height) % min(plane.height, base.height):
        raise InputError(
            f"{name} is {size}, {first} {other}; give it the same size, or a whole multiple or fraction of it."
        )


def finite(plane: Plane) -> bool:
    """Whether no pixel of a plane is NaN or infinite."""
    return not plane.is_float or bool(np.isfinite(plane.samples).all())


def _plane(name: str, pixels: ArrayLike | Plane) -> Plane:
    if isinstance(pixels, Plane):
        return pixels
    kind = KIND_OF_NAME.get(name, Kind.COLOUR)
    array = np.ma.getdata(pixels) if isinstance(pixels, np.ma.MaskedArray) else pixels_of(pixels, kind is Kind.LABEL)
    return Plane(array.astype(np.uint8) * 255 if array.dtype == bool and kind is not Kind.LABEL else array, kind)


def _both(mask: Mask, other: Mask) -> Mask:
    """Return the intersection of two masks; `mask` alone if sizes differ, which the caller refuses later."""
    return mask & other if mask.shape == other.shape else mask


def resized(mask: Mask, size: Pair) -> Mask:
    """Return a mask resized to (height, width) by a whole factor; when reduced, a pixel is True if any in it is."""
    if mask.shape[0] > size[0]:
        times = mask.shape[0] // size[0]
        if mask.shape != (size[0] * times, size[1] * times):
            return np.zeros(size, bool)  # no plane of this exemplar, which says so
        return np.asarray(mask.reshape(size[0], times, size[1], times).any(axis=(1, 3)))
    times = size[0] // mask.shape[0]
    return mask.repeat(times, axis=0).repeat(times, axis=1)


def sampled(exemplars: Sequence[Exemplar]) -> list[Exemplar]:
    """Return the exemplars with usable pixels; all if there are none."""
    return [e for e in exemplars if e.usable is None or e.usable.any()] or list(exemplars)
