"""Source map: for every output pixel the coordinates of the exemplar pixel it is copied from; saved as .npz.

Pictures are renderings of a map. Files are read defensively: headers of arrays are checked before memory is allocated.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from ..disk import check_decoding_cost, no_room
from ..disk.atomic import file_size
from ..foundation import (
    InputError,
    IntarsiaError,
    ParameterError,
    Record,
    ResourceError,
    chosen,
    expect,
    expect_path,
    legible,
    ndimage,
    printable,
)
from ..foundation.arrays import Array, Float32, Floats, Int32, Int64, Mask, UInt8
from ..foundation.blend import Blend
from ..foundation.geometry import ISOMETRIES, Box, Shaped, Wrap

AREA = 64.0
"""Largest determinant of a frame, by absolute value, and the inverse of the least."""

STEP = 64.0
"""Largest entry of a frame: px in the exemplar along each axis for one px in the output."""

ASIDE = 1.0
"""Largest fraction (``sub``) from the exemplar pixel of an entry, px along each axis."""

ROWS = 16
"""Rows of a map that are checked at a time, so that temporary arrays fit into a core's cache."""

UPRIGHT = np.eye(2, dtype=np.float32)

NEAR = 1.0
"""Greatest deviation in px of a neighbour from the continued position, along each axis; rounding may reach it."""

BESIDE = (np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])
"""All pixels that have a next one along an axis, and these next ones."""

_POSES = np.array([isometry.j for isometry in ISOMETRIES], np.int64)


def frozen(name: str, value: Any, dtype: Any, shape: tuple[int, ...] | None) -> Array | None:
    """Return an array of a map, read-only and of type `dtype`; InputError if it has another shape.

    A `shape` of None stands for (height, width, 2), that of ``yx``.
    """
    if value is None and shape is not None:
        return None
    with np.errstate(over="ignore", invalid="ignore"):  # what becomes infinite is refused as such
        try:
            array = np.ascontiguousarray(value, dtype=dtype)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name} of a map holds no numbers; give an array.") from None
    if shape is None and (array.ndim != 3 or array.shape[2] != 2):
        raise InputError(f"{name} of shape {array.shape} is no map; it needs (height, width, 2).")
    if shape is not None and array.shape != shape:
        raise InputError(f"{name} of shape {array.shape} does not fit the map of shape {shape}.")
    array = array.view()
    array.flags.writeable = False
    return array


def check_frames(frame: Array | None, sub: Array | None, pose: Array | None, holes: Array) -> None:
    """Check frames and fractions; values in holes are ignored.

    Raises
    ------
    InputError
        if both frame and pose are given; if a frame is not finite, scales areas by more than 64 or less than 1/64, or
        takes steps of more than 64 px; if a fraction is not finite, or more than 1 px.
    """
    if frame is not None:
        if pose is not None:
            raise InputError("the map has both pose and frame; give one, a frame can say all that a pose can.")
        if bad := sum(_unsound(frame[k : k + ROWS], holes[k : k + ROWS]) for k in range(0, len(frame), ROWS)):
            raise InputError(
                f"frame holds {bad} matrices that are not finite, take steps of more than {STEP:.0f} px, or scale "
                f"areas by more than {AREA:.0f} or less than 1/{AREA:.0f}; give others."
            )
    if sub is not None and (bad := int((~(np.abs(sub) <= ASIDE).all(axis=2) & ~holes).sum())):
        raise InputError(
            f"sub holds {bad} fractions that are not finite or beyond {ASIDE:.0f} px; let yx name the nearest pixel."
        )


def _unsound(frame: Array, holes: Array) -> int:
    """Return the number of invalid frames outside of holes."""
    with np.errstate(invalid="ignore", over="ignore"):
        yy, yx, xy, xx = (np.ascontiguousarray(frame[..., m, n], np.float64) for m in (0, 1) for n in (0, 1))
        area = np.abs(yy * xx - yx * xy)
        fine = (area >= 1 / AREA) & (area <= AREA)
        for part in (yy, yx, xy, xx):
            fine &= np.abs(part) <= STEP
    return int((~fine & ~holes).sum())


def matrices(frame: Array | None, pose: Array) -> Floats:
    """Return the Jacobian of every pixel, (H, W, 2, 2), from frames, or from poses if there are none."""
    return (_POSES[np.minimum(pose, 7)] if frame is None else frame).astype(np.float64)


def positions(yx: Array, sub: Array | None) -> Floats:
    """Return the exemplar position of every pixel, (H, W, 2), fractions included."""
    return yx + (np.zeros(2) if sub is None else sub.astype(np.float64))


HOLE = 255
"""Value of ``which`` for pixels that are not filled yet."""

_TYPES = {"yx": np.int32, "which": np.uint8, "pose": np.uint8, "frame": np.float32, "sub": np.float32}


@dataclass(frozen=True)
class Source(Shaped):
    """The entry of an exemplar in a map: its name, its size in px, and the digest of its content."""

    name: str
    height: int
    width: int
    digest: str


@dataclass(frozen=True, eq=False)
class SourceMap(Shaped):
    """Source map: for every output pixel (H, W) the exemplar pixel it is copied from, and the isometry of the copy.

    Parameters
    ----------
    yx : int32 array, shape (H, W, 2)
        Row and column of the exemplar pixel; (0, 0) in holes.
    which : uint8 array, shape (H, W), optional
        Number of the exemplar; ``HOLE`` (255) in holes. None: exemplar 0 everywhere.
    pose : uint8 array, shape (H, W), optional
        Number 0..7 of the isometry of the copy (`foundation.geometry.ISOMETRIES`). None: 0, the identity, everywhere.
    sources : sequence of Source
        The exemplars, in the order of their numbers.
    wrap : {"none", "x", "y", "both"}
        Along which axes the map is periodic, default "none".
    blend : Blend
        The default blend of the method, default no blending.
    frame : float32 array, shape (H, W, 2, 2), optional
        Instead of ``pose`` if pieces are scaled, rotated or warped: the Jacobian from steps (y, x) in the output to
        steps in the exemplar. It scales areas by at most 64, at least 1/64.
    sub : float32 array, shape (H, W, 2), optional
        Offset (y, x) from the exemplar pixel, -1 to 1 px, mostly -0.5 to 0.5. None: 0 everywhere.

    Raises
    ------
    InputError
        if shapes do not fit, both ``pose`` and ``frame`` are given, or frames or offsets are out of range.
    """

    yx: Int32
    which: UInt8 | None = None
    pose: UInt8 | None = None
    sources: tuple[Source, ...] = ()
    wrap: Wrap = Wrap.NONE
    blend: Blend = field(default_factory=Blend)
    frame: Float32 | None = None
    sub: Float32 | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "yx", frozen("yx", self.yx, np.int32, None))
        size = self.yx.shape[:2]
        for name, shape in (("which", size), ("pose", size), ("frame", (*size, 2, 2)), ("sub", (*size, 2))):
            object.__setattr__(self, name, frozen(name, getattr(self, name), _TYPES[name], shape))
        if not self.exact:
            check_frames(self.frame, self.sub, self.pose, self.holes)
        object.__setattr__(self, "sources", tuple(self.sources))
        object.__setattr__(self, "wrap", chosen(Wrap, "wrap", self.wrap))

    def __repr__(self) -> str:
        return f"<map: {self.width}x{self.height} px, of {', '.join(s.name for s in self.sources) or 'no exemplar'}>"

    @property
    def height(self) -> int:
        """Rows of the output."""
        return int(self.yx.shape[0])

    @property
    def width(self) -> int:
        """Columns of the output."""
        return int(self.yx.shape[1])

    @property
    def exact(self) -> bool:
        """Whether pixels are copied bit for bit; with frames or fractions they are interpolated."""
        return self.frame is None and self.sub is None

    @property
    def holes(self) -> Mask:
        """Mask of the pixels that are not filled."""
        return np.asarray(self.numbers == HOLE)

    @property
    def poses(self) -> tuple[int, ...]:
        """The isometries that occur."""
        if self.pose is None:
            return (0,)
        return tuple(int(p) for p in np.unique(self.pose[~self.holes]))

    def window(self, box: Box) -> SourceMap:
        """Return the map of a box; along periodic axes it may cross the border, or lie anywhere.

        Raises ParameterError for a box that is empty, or lies outside of the map along another axis.
        """
        expect(box, Box, "the window", "a Box")
        rows = _positions(box.y0, box.y1, self.height, self.wrap.y, "rows")
        columns = _positions(box.x0, box.x1, self.width, self.wrap.x, "columns")
        index = np.ix_(rows, columns)
        return replace(self, **{name: array[index] for name, array in self.arrays.items()}, wrap=Wrap.NONE)

    def pieces(self) -> Int32:
        """Return the labels of connected pieces, (H, W) int32: neighbours with the same offset share a label.

        With frames or fractions: neighbours that lie within 1 px of where the mean of their frames leads.
        """
        joined, holes = np.zeros([2 * n - 1 for n in self.shape], bool), self.holes
        joined[::2, ::2] = True
        for axis, between in enumerate((joined[1::2, ::2], joined[::2, 1::2])):
            this, that = BESIDE[axis]
            between[:] = ~self.parted(axis) | holes[this] & holes[that]
        return np.asarray(ndimage.label(joined)[0][::2, ::2] - 1)

    def steps(self, axis: int) -> Array:
        """Return where the next pixel along an axis lies in the exemplar if a piece goes on, from each: (H, W, 2)."""
        if self.frame is not None:
            return self.frame[:, :, :, axis].astype(np.float64)
        return np.asarray(_POSES[:, :, axis][np.minimum(self.turns, 7)])

    def parted(self, axis: int) -> Mask:
        """Return where a pixel and the next along an axis are of different pieces; one row, or column, fewer."""
        this, that = BESIDE[axis]
        which, pose = self.numbers, self.turns
        out: Mask = (which[this] != which[that]) | (pose[this] != pose[that])
        steps = self.steps(axis)
        for k in range(2):
            at = self.yx[:, :, k] if self.sub is None else self.yx[:, :, k] + self.sub[:, :, k].astype(np.float64)
            ahead, step = at[that] - at[this], steps[:, :, k]
            out |= (ahead != step[this]) if self.exact else np.abs(ahead - (step[this] + step[that]) / 2) > NEAR
        return out

    def usage(self) -> list[Int64]:
        """Return how often every pixel of each exemplar is used: int64 (height, width) for each.

        Raises InputError if the map points outside its exemplars, ResourceError if memory is short.
        """
        if self.sources:
            self.check_sources()
        which = self.numbers
        counts = []
        for number, source in enumerate(self.sources):
            mine = which == number
            yx = self.yx.reshape(-1, 2) if mine.all() else self.yx[mine]
            pixels = source.height * source.width
            try:
                flat = np.bincount(yx[:, 0].astype(np.int64) * source.width + yx[:, 1], minlength=pixels)
            except (MemoryError, OverflowError):
                size = f"{source.width}x{source.height} px"
                raise ResourceError(f"the exemplar {source.name} of {size} is too large to count its uses.") from None
            counts.append(flat.reshape(source.shape))
        return counts

    def st_map(self) -> Float32:
        """Return an ST map for compositing tools: (H, W, 2) float32, (s, t) in 0..1, t upward, pixel centres.

        Raises ParameterError for maps of several exemplars.
        """
        if len(self.sources) != 1:
            raise ParameterError(
                f"an ST map shows one exemplar, this map has {len(self.sources)}; save the map itself."
            )
        size = self.sources[0]
        at = positions(self.yx, self.sub)
        s = (at[:, :, 1] + 0.5) / size.width
        t = 1.0 - (at[:, :, 0] + 0.5) / size.height
        return np.stack([s, t], axis=2).astype(np.float32)

    def save(self, path: str | Path) -> None:
        """Write the map as .npz, arrays under their names; a file that exists is replaced atomically."""
        from ..disk.atomic import write_bytes

        expect_path(path)
        write_bytes(path, self.to_bytes(), force=True)

    def to_bytes(self) -> bytes:
        """Return the content of the .npz file; equal maps give equal bytes."""
        about = {"sources": [asdict(s) for s in self.sources], "wrap": self.wrap.value, **self.blend.as_recipe}
        said = {"about": np.frombuffer(json.dumps(about).encode(), dtype=np.uint8)}
        return packed({"yx": self.yx, **said, **self.arrays})

    @classmethod
    def load(cls, path: str | Path) -> SourceMap:
        """Read a map that :meth:`save` wrote; InputError for anything else, ResourceError if memory is short.

        The limit of pictures holds for maps (``INTARSIA_MAX_PIXELS``); sizes are checked before arrays are read.
        """
        expect_path(path)
        with unpacked(path) as (arrays, about):
            return cls(
                **arrays, sources=tuple(_source(**s) for s in about["sources"]), wrap=Wrap(about["wrap"]),
                blend=Blend.of(about),
            )  # fmt: skip

    @property
    def digest(self) -> str:
        """SHA-256 of the arrays and the wrap, as 64 hexadecimal digits."""
        h = hashlib.sha256(f"{self.yx.shape}{self.wrap}".encode())
        for part in (self.yx.astype("<i4", copy=False), self.numbers, self.turns):
            h.update(np.ascontiguousarray(part).data)
        for name in ("frame", "sub"):
            if name in self.arrays:
                h.update(name.encode())
                h.update(self.arrays[name].astype("<f4", copy=False).data)
        return h.hexdigest()

    def check_sources(self) -> None:
        """Raise InputError if the map points outside its exemplars."""
        which, pose = self.numbers, self.turns
        if pose.max(initial=0) > 7:
            raise InputError("the map holds isometries above 7; it is damaged.")
        known = which != HOLE
        if known.any() and int(which[known].max()) >= len(self.sources):
            raise InputError("the map names exemplars that it does not list; it is damaged.")
        for number, source in enumerate(self.sources):
            yx = self.yx[which == number]
            if yx.size and (yx.min() < 0 or yx[:, 0].max() >= source.height or yx[:, 1].max() >= source.width):
                raise InputError(f"the map points outside its exemplar {source.name}; it is damaged.")

    @property
    def arrays(self) -> Record:
        """The arrays that there are, by name."""
        return {name: getattr(self, name) for name in _TYPES if getattr(self, name) is not None}

    @property
    def numbers(self) -> UInt8:
        """The number of the exemplar of every pixel (H, W), also if ``which`` is None."""
        return np.zeros(self.shape, np.uint8) if self.which is None else self.which

    @property
    def turns(self) -> UInt8:
        """The isometry of every pixel (H, W), also if ``pose`` is None."""
        return np.zeros(self.shape, np.uint8) if self.pose is None else self.pose


def identity(sources: Sequence[Source], number: int) -> SourceMap:
    """Return the identity map of one exemplar, the start map of extending or healing it."""
    source = sources[number]
    yx = np.moveaxis(np.indices(source.shape, dtype=np.int32), 0, 2)
    return SourceMap(yx, np.full(yx.shape[:2], number, np.uint8), sources=tuple(sources))


def _source(name: Any, height: Any, width: Any, digest: Any) -> Source:
    """Return the entry of an exemplar from a file; ValueError if it is damaged."""
    sides = all(type(side) is int and 0 < side <= MOST_SIDE for side in (height, width))
    if not (isinstance(name, str) and isinstance(digest, str) and sides and height * width <= MOST_AREA):
        raise ValueError
    return Source(name, height, width, digest)


def _positions(start: int, stop: int, length: int, wrap: bool, axis: str) -> Int64:
    check_stretch(start, stop, length, wrap, axis)
    return np.arange(start, stop) % length


def check_stretch(start: int, stop: int, length: int, wrap: bool, axis: str) -> None:
    """Raise ParameterError for a range of rows or columns (`axis`) outside of a canvas of `length` px."""
    if stop <= start or (not wrap and (start < 0 or stop > length)):
        raise ParameterError(
            f"window {axis} {start}..{stop} do not lie in 0..{length}; choose others, or wrap the canvas."
        )


LONGEST = 1 << 24
"""Most bytes of the metadata of a map."""

MOST_SIDE, MOST_AREA = (1 << 31) - 1, 1 << 31
"""Most px of a map, and of its exemplars, along a side and in all."""

_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def packed(arrays: Mapping[str, Any]) -> bytes:
    """Return the content of a .npz; equal arrays give equal bytes.

    Compressed at zlib's fastest level: a sixth larger, in a tenth of the time.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.asanyarray(array), allow_pickle=False)
    return buffer.getvalue()


@contextmanager
def unpacked(path: str | Path) -> Iterator[tuple[dict[str, Array], Record]]:
    """Yield the arrays of a saved map and its metadata; failures meanwhile are reported in one line.

    Raises
    ------
    InputError
        if the file cannot be read or is no map, or is a decompression bomb.
    ResourceError
        if it does not fit into memory.
    """

    name = printable(path)
    size = file_size(Path(path), name, "a map saved with --save-map")
    try:
        with open(path, "rb") as file:
            with zipfile.ZipFile(file) as archive:
                cost = _measured(archive)
            check_decoding_cost(name, cost, size)
            file.seek(0)
            with np.load(file, allow_pickle=False) as data:
                about = json.loads(bytes(data["about"]))
                arrays = {k: data[k] for k in _TYPES if k in data}
        yield arrays, about
    except MemoryError:
        raise no_room(name) from None
    except OSError as e:
        reason = (e.strerror or legible(str(e))).lower()
        raise InputError(f"{name} cannot be read ({reason}); check the permissions, or copy it again.") from None
    except Exception as e:  # a damaged archive can fail in any way
        if isinstance(e, InputError) and str(e).startswith(name):
            raise
        why = str(e).rstrip(".") if isinstance(e, IntarsiaError) else type(e).__name__
        raise InputError(f"{name} is no map of intarsia ({why}); give one saved with --save-map.") from None


def _measured(archive: zipfile.ZipFile) -> int:
    """Return the size of the arrays in bytes, from their headers; ValueError if they are not those of a map."""
    cost, held = 0, set(archive.namelist())
    if not {"yx.npy", "about.npy"} <= held:
        raise ValueError
    for name in ("about", *_TYPES):
        if name + ".npy" not in held:
            continue
        with archive.open(name + ".npy") as file:
            shape, _, dtype = _HEADERS[np.lib.format.read_magic(file)](file)
        area, sides = prod(shape), shape[:2]
        if name == "about":
            if area * dtype.itemsize > LONGEST:
                raise ValueError
        elif dtype != _TYPES[name] or not shape or min(sides) < 1 or max(sides) > MOST_SIDE or prod(sides) > MOST_AREA:
            raise ValueError
        cost += area * dtype.itemsize
    return cost
