"""How much a picture may cost that nobody asked for: pixels, and memory against the bytes that really are there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from ..errors import InputError, ParameterError, ResourceError

MAX_PIXELS = 1 << 28
"""Nobody can ask for more."""

DEFAULT_PIXELS = 1 << 26
"""What a picture may have where nobody says otherwise: 8192x8192."""

VARIABLE = "INTARSIA_MAX_PIXELS"
"""The environment variable that sets another default, above which nobody can ask."""

SIDE = 1 << 20
MAX_CHANNELS = 64
FREE = 6
"""Bytes of memory for each pixel that is allowed, which a file may take however small it is."""

HELD = 32
"""Bytes of memory for each byte of the file, which it may take beyond that: real textures hold what they unpack to."""

_asked: ContextVar[int | None] = ContextVar("max_pixels", default=None)


@contextmanager
def allowing(pixels: int | None) -> Iterator[None]:
    """Let pictures of so many pixels be read in the meantime; None: as the environment says.

    Raises ParameterError where the environment variable allows less, or that is more than 2**28.
    """
    if pixels is not None:
        ceiling = _of_environment() or MAX_PIXELS
        if not 1 <= pixels <= ceiling:
            raise ParameterError(f"--max-pixels {pixels} is not allowed; give 1 to {ceiling}{_why(ceiling)}.")
    token = _asked.set(pixels)
    try:
        yield
    finally:
        _asked.reset(token)


def most_pixels() -> int:
    """How many pixels a picture may have just now."""
    return _asked.get() or _of_environment() or DEFAULT_PIXELS


def check_size(name: str, width: int, height: int, channels: int = 1, side: int = SIDE) -> None:
    """Refuse a picture by the size that its header states, before anything is unpacked."""
    if width < 1 or height < 1:
        raise InputError(f"{name} has no pixels ({width}x{height}); save it again.")
    if max(width, height) > side:
        raise InputError(f"{name} claims {width}x{height} px; at most {side} px a side are allowed, so crop it first.")
    most = most_pixels()
    if width * height > most:
        raise InputError(
            f"{name} claims {width}x{height} px; at most {most} pixels are allowed, so {_remedy(width * height)}."
        )
    if channels > MAX_CHANNELS:
        raise InputError(f"{name} has {channels} channels; at most {MAX_CHANNELS}, so save fewer.")


def check_cost(name: str, cost: float, held: int) -> None:
    """Refuse a file of `held` bytes that takes `cost` bytes of memory, or as much time, for next to nothing in it."""
    most = most_pixels()
    if cost <= max(FREE * most, HELD * held) or most >= MAX_PIXELS:
        return
    raise InputError(
        f"{name} would take {_words(cost)} of memory, with {_words(held)} in the file; so small a one may take "
        f"{_words(FREE * most)}, so {_remedy(min(-(-int(cost) // FREE), MAX_PIXELS))}."
    )


def no_room(name: str) -> ResourceError:
    """Say that a file does not fit into memory."""
    return ResourceError(f"{name} does not fit into memory; crop it first, or free some.")


def _remedy(needed: int) -> str:
    ceiling = _of_environment() or MAX_PIXELS
    if needed > ceiling:
        return f"crop it first (nobody may ask for more than {ceiling}{_why(ceiling)})"
    return f"crop it first, or allow more with --max-pixels {needed} ({VARIABLE}={needed})"


def _why(ceiling: int) -> str:
    return f", as {VARIABLE} says" if ceiling < MAX_PIXELS else ""


def _of_environment() -> int | None:
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return None
    if not text.isascii() or not text.isdigit() or not 1 <= int(text[:20]) <= MAX_PIXELS:
        raise ParameterError(f"{VARIABLE}={text[:40]} is not allowed; give 1 to {MAX_PIXELS} pixels, or unset it.")
    return int(text)


def _words(count: float) -> str:
    return f"{int(count) >> 20} MiB" if count >= 1 << 20 else f"{-(-int(count) >> 10)} KiB" if count >= 1 << 10 else (
        f"{int(count)} bytes"
    )  # fmt: skip
