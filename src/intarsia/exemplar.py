"""The exemplar: aligned planes of one surface, which of its pixels may be used, and what is known of it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError
from .image import Kind, Plane
from .sourcemap import Source

T = TypeVar("T")

KIND_OF_NAME = {
    "normal": Kind.NORMAL,
    "height": Kind.DATA,
    "roughness": Kind.DATA,
    "metallic": Kind.DATA,
    "ao": Kind.DATA,
    "opacity": Kind.DATA,
    "specular": Kind.DATA,
    "orm": Kind.DATA,
    "label": Kind.LABEL,
    "labels": Kind.LABEL,
    "id": Kind.LABEL,
    "ids": Kind.LABEL,
}
"""What a plane of this name holds; any other name is a colour."""

REDUCED = "(reduced)"
"""The first plane of a magnified exemplar: its base at reduced size, which is compared and never written."""


@dataclass(frozen=True, eq=False)
class Exemplar:
    """An example of a texture: one or more aligned planes.

    Parameters
    ----------
    planes : dict of str to Plane
        The first plane is the base, which sets the size. The others have its size, or a whole multiple of it,
        or a whole fraction.
    usable : bool array, shape (H, W), optional
        False where pixels must not be sampled. None: all may be. None at all may be usable: such a picture can
        still lie under a start map.
    toroidal : bool
        True where the exemplar continues in itself across its borders.
    name : str
        A short name, for messages and maps.

    Raises
    ------
    InputError
        where sizes do not fit, or a usable pixel is NaN or infinite.
    """

    planes: Mapping[str, Plane]
    usable: NDArray[np.bool_] | None = None
    toroidal: bool = False
    name: str = "exemplar"
    _memo: dict[Any, Any] = field(default_factory=dict, repr=False, init=False)

    def __post_init__(self) -> None:
        if not self.planes:
            raise InputError("an exemplar needs at least one plane.")
        object.__setattr__(self, "planes", dict(self.planes))
        for name, plane in self.planes.items():
            self._check_size(name, plane)
        if self.usable is not None:
            usable = np.array(self.usable, dtype=bool)
            if usable.shape != (self.height, self.width):
                raise InputError(
                    f"the mask is {usable.shape[-1]}x{usable.shape[0]} px, the exemplar "
                    f"{self.width}x{self.height}; make them equal."
                )
            usable.flags.writeable = False
            object.__setattr__(self, "usable", None if usable.all() else usable)
        for name, plane in self.planes.items():
            self._check_finite(name, plane)

    @classmethod
    def of(
        cls,
        pixels: ArrayLike | Plane | Mapping[str, ArrayLike | Plane] | Exemplar,
        *,
        usable: ArrayLike | None = None,
        toroidal: bool = False,
        name: str = "exemplar",
    ) -> Exemplar:
        """Make an exemplar of an array, a plane, or a dict of them; names such as ``normal`` tell the kind."""
        if isinstance(pixels, Exemplar):
            return pixels
        planes = pixels if isinstance(pixels, Mapping) else {"albedo": pixels}
        mask = None if usable is None else np.asarray(usable)
        if mask is not None and mask.ndim != 2:
            raise InputError(f"a mask of shape {mask.shape} does not fit; give (height, width).")
        return cls({n: _plane(n, p) for n, p in planes.items()}, mask, toroidal, name)

    @property
    def base(self) -> Plane:
        """The plane that sets the size."""
        return next(iter(self.planes.values()))

    @property
    def shown(self) -> tuple[str, ...]:
        """The names of the planes that are drawn: all, but for the reduced one of a magnified exemplar."""
        names = tuple(self.planes)
        return names[1:] if names[0] == REDUCED and len(names) > 1 else names

    @property
    def compared(self) -> tuple[str, ...]:
        """The names of the planes that say what fits: all, but for the one that a reduced plane stands for."""
        names = tuple(self.planes)
        return names if self.shown == names else (names[0], *names[2:])

    @property
    def times(self) -> int:
        """How many times larger than the map the pictures of a magnified exemplar are; 1 for all others."""
        return 1 if REDUCED not in self.planes else max(self.planes[self.shown[0]].height // self.height, 1)

    @property
    def height(self) -> int:
        """Rows of the base plane."""
        return self.base.height

    @property
    def width(self) -> int:
        """Columns of the base plane."""
        return self.base.width

    @property
    def source(self) -> Source:
        """What a map remembers of this exemplar."""
        return Source(self.name, self.height, self.width, self.digest)

    @property
    def digest(self) -> str:
        """SHA-256 of all that matters for a result, as 64 hexadecimal digits."""
        return self.memo("digest", self._digest)

    def memo(self, key: Any, make: Callable[[], T]) -> T:
        """Return what is known under `key`, making it at the first asking."""
        if key not in self._memo:
            self._memo[key] = make()
        value: T = self._memo[key]
        return value

    def latest(self, name: str, key: Any, make: Callable[[], T]) -> T:
        """Return what was made last under `name` if it was for `key`; else make it, in place of the other."""
        found = self._memo.get(name)
        if found is None or found[0] != key:
            found = self._memo[name] = key, make()
        value: T = found[1]
        return value

    def _digest(self) -> str:
        h = hashlib.sha256()
        for name, plane in self.planes.items():
            p = plane.pixels
            h.update(f"{name}|{plane.kind}|{plane.transfer}|{p.dtype}|{p.shape}|".encode())
            h.update(p.astype(p.dtype.newbyteorder("<"), copy=False).data)
        h.update(b"mask" + (b"" if self.usable is None else np.packbits(self.usable).tobytes()))
        h.update(b"toroidal" if self.toroidal else b"")
        return h.hexdigest()

    def _check_size(self, name: str, plane: Plane) -> None:
        for mine, base in ((plane.height, self.height), (plane.width, self.width)):
            if max(mine, base) % min(mine, base):
                raise InputError(
                    f"the plane {name} is {plane.width}x{plane.height} px, the base {self.width}x{self.height}; "
                    "give it the same size, or a whole multiple or fraction of it."
                )
        if plane.height * self.width != plane.width * self.height:
            raise InputError(
                f"the plane {name} is {plane.width}x{plane.height} px, of another shape than the base "
                f"({self.width}x{self.height}); scale both axes alike."
            )

    def _check_finite(self, name: str, plane: Plane) -> None:
        if not plane.is_float:
            return
        bad = ~np.isfinite(plane.samples).all(axis=2)
        if self.usable is not None and plane.height >= self.height:
            s = plane.height // self.height
            bad &= self.usable.repeat(s, axis=0).repeat(s, axis=1)
        if bad.any():
            raise InputError(
                f"{int(bad.sum())} pixels of the plane {name} are NaN or infinite; "
                "repair them, or mask them out (--mask)."
            )


def _plane(name: str, pixels: ArrayLike | Plane) -> Plane:
    if isinstance(pixels, Plane):
        return pixels
    kind = KIND_OF_NAME.get(name, Kind.COLOUR)
    array = np.asarray(pixels)
    return Plane(array.astype(np.uint8) * 255 if array.dtype == bool and kind is not Kind.LABEL else array, kind)
