"""Saved maps and recipes that are broken or lie, made by small code when a test asks for them."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from corpus import EITHER, OK, REFUSED, Case

MAPS: dict[str, Case] = {}

ABOUT = {
    "sources": [{"name": "a", "height": 20, "width": 24, "digest": "0" * 64}],
    "wrap": "none", "feather": 0, "mixing": "mean",
}  # fmt: skip


FORM: dict[str, Any] = {
    "parameters": {}, "blend": {"feather": 0, "mixing": "mean"}, "exemplars": [{"name": "a", "sha256": "0" * 64}],
}  # fmt: skip
"""As much of a recipe as it takes to name the cases."""


def packed(about: Any = ABOUT, **arrays: Any) -> bytes:
    """An archive as maps are saved; `about` may be bytes, and None leaves it out."""
    held: dict[str, Any] = {"yx": np.zeros((6, 7, 2), np.int32)} | arrays
    if about is not None:
        text = about if isinstance(about, bytes) else json.dumps(about).encode()
        held["about"] = np.frombuffer(text, np.uint8)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **{k: v for k, v in held.items() if v is not None})
    return buffer.getvalue()


def keep(cases: dict[str, Case], name: str, outcome: str, data: Callable[[], bytes] | bytes, file: str) -> None:
    def make(folder: Path) -> Path:
        path = folder / file
        path.write_bytes(data() if callable(data) else data)
        return path

    cases[name] = Case(make, outcome)


def add_map(name: str, outcome: str, data: Callable[[], bytes] | bytes) -> None:
    keep(MAPS, "map " + name, outcome, data, "m.npz")


def said(**change: Any) -> bytes:
    return packed({k: v for k, v in (ABOUT | change).items() if v != "gone"})


def source(**change: Any) -> bytes:
    return said(sources=[ABOUT["sources"][0] | change])  # type: ignore[index, operator]


def lying(shape: str, held: bytes = bytes(64), packing: int = zipfile.ZIP_STORED) -> bytes:
    """An archive with an array that claims another shape than it has."""
    head = f"{{'descr': '<i4', 'fortran_order': False, 'shape': {shape}, }}".encode().ljust(117) + b"\n"
    buffer = io.BytesIO(packed(yx=None))
    with zipfile.ZipFile(buffer, "a", packing) as archive:
        archive.writestr("yx.npy", b"\x93NUMPY\1\0" + len(head).to_bytes(2, "little") + head + held)
    return buffer.getvalue()


def zipped(*files: tuple[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files:
            archive.writestr(name, data)
    return buffer.getvalue()


def unpacking_to(size: int) -> bytes:
    """A sound archive whose directory says that an array has so many bytes."""
    data = bytearray(packed())
    at = data.rfind(b"PK\1\2", 0, data.rfind(b"yx.npy"))
    data[at + 24 : at + 28] = size.to_bytes(4, "little")
    return bytes(data)


def _maps() -> None:
    yx = np.zeros((6, 7, 2), np.int32)
    which = np.zeros((6, 7), np.uint8)
    add_map("sound", OK, packed())
    add_map("with holes", EITHER, packed(which=which + 255))
    for name, data in {
        **{f"cut {part} of 16": packed()[: len(packed()) * part // 16] for part in (1, 4, 8, 12, 15)},
        "zero bytes": b"", "text": b"yx = 1\n", "one array": _npy(yx), "no yx": packed(yx=None),
        "no about": packed(None), "pickled yx": packed(yx=np.array([[{}]], dtype=object)),
        "pickle": zipped(("yx.npy", b"cos\nsystem\n(S'true'\ntR."), ("about.npy", b"")),
    }.items():  # fmt: skip
        add_map(name, REFUSED, data)
    for name, array in (
        ("float", yx + 0.5), ("nan", yx * np.nan), ("int64", yx.astype(np.int64) + (1 << 40)), ("complex", yx * 1j),
        ("text", yx.astype(str)), ("flat", yx[:, :, 0]), ("deep", yx[..., None]),
        ("three", np.dstack([yx, yx])[:, :, :3]),
        ("no rows", yx[:0]), ("no columns", yx[:, :0]), ("scalar", np.int32(1)), ("negative", yx - 1),
        ("outside", yx + 20), ("far outside", yx + (1 << 30)),
    ):  # fmt: skip
        add_map(f"yx {name}", REFUSED, packed(yx=array))
    for name, array in (
        ("another shape", which[:5]), ("deep", which[..., None]), ("float", which + 0.5), ("unlisted", which + 1),
        ("254", which + 254),
    ):  # fmt: skip
        add_map(f"which {name}", REFUSED, packed(which=array))
    for name, data in {
        "pose 8": packed(pose=which + 8), "pose another shape": packed(pose=which[:, 1:]),
        "about no json": packed(b"{"), "about binary": packed(b"\xff\xfe\0"), "about deep": packed(b"[" * 100_000),
        "about list": packed([1]), "about number": packed(7),
    }.items():  # fmt: skip
        add_map(name, REFUSED, data)
    hostile: dict[str, list[Any]] = {
        "sources": ["gone", None, 3, "abc", [[]], [3], [None], {}, []],
        "wrap": ["gone", None, 3, "diagonal", []],
        "feather": ["gone", None, "3", -1, 5000, float("nan"), float("inf"), True, [1], 0.5],
        "mixing": ["gone", None, "well", 3],
        "source name": [3, None, []],
        "source height": [0, -20, "20", None, 20.5, True, 1 << 70, 19],
        "source width": [0, "x", float("nan")],
        "source digest": [None, 5],
    }
    for key, values in hostile.items():
        for value in values:
            data = source(**{key[7:]: value}) if key.startswith("source ") else said(**{key: value})
            add_map(f"{key} {value!r}", REFUSED, data)
    add_map("source more", REFUSED, source(colour="red"))
    add_map("two sources", REFUSED, said(sources=ABOUT["sources"] * 2))  # type: ignore[operator]
    add_map("claims 10^12 px", REFUSED, lying("(1000000, 1000000, 2)"))
    add_map("claims 2^40 rows", REFUSED, lying("(1099511627776, 0, 2)"))
    add_map("claims negative rows", REFUSED, lying("(-4, -2, 2)"))
    add_map("claims words", REFUSED, lying("('a', 2)"))
    add_map("directory lies", EITHER, unpacking_to(0xFFFFFFF0))
    add_map("bomb", REFUSED, lambda: zipped(("about.npy", bytes(70 << 20)), ("yx.npy", b"")))
    add_map("nested zip", REFUSED, zipped(("yx.npy", zipped(("a", bytes(1 << 20))))))
    add_map("climbing names", REFUSED, zipped(("../../yx.npy", b"x"), ("/etc/about.npy", b"x")))
    add_map("repeated names", EITHER, lambda: _twice())


def _npy(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def _twice() -> bytes:
    import warnings

    buffer = io.BytesIO(packed())
    with warnings.catch_warnings(), zipfile.ZipFile(buffer, "a") as archive:
        warnings.simplefilter("ignore")
        archive.writestr("yx.npy", _npy(np.zeros((9, 9, 2), np.int32) + 500))
    return buffer.getvalue()


def recipes(sound: dict[str, Any]) -> dict[str, Case]:
    """Recipes that differ from a sound one in one thing each."""
    found: dict[str, Case] = {}

    def add(name: str, outcome: str, content: Any) -> None:
        keep(found, "recipe " + name, outcome, content if isinstance(content, bytes) else json.dumps(content).encode(),
             "r.json")  # fmt: skip

    add("sound", OK, sound)
    add("future", OK, sound | {"intarsia": "99.0", "more": {"x": 1}})
    for name, content in (
        ("nothing", b""), ("list", []), ("number", 3), ("null", None), ("half", json.dumps(sound).encode()[:80]),
        ("binary", b"\xff\xfe{}"), ("deep", b"[" * 100_000), ("deep dict", b'{"a":' * 50_000), ("empty", {}),
        ("digits", b'{"seed": ' + b"9" * 5000 + b"}"), ("zeros", bytes(1000)),
    ):  # fmt: skip
        add(name, REFUSED, content)
    hostile: list[Any] = [None, "q", "", -1, 1.5, [], {}, [[]], True, float("nan"), 1 << 70, "../../etc/passwd"]
    for key in ("method", "parameters", "size", "wrap", "blend", "exemplars", "seed"):
        add(f"without {key}", REFUSED, {k: v for k, v in sound.items() if k != key})
        for value in hostile:
            fine = key == "parameters" and value == {}
            add(f"{key} {value!r}", EITHER if fine else REFUSED, sound | {key: value})
    for name, value in (("0x0", [0, 0]), ("-3", [-3, 4]), ("huge", [99999999, 99999999]), ("three", [4, 4, 4]),
                        ("words", ["4", "4"]), ("half", [4.5, 4]), ("one", [4])):  # fmt: skip
        add(f"size of {name}", REFUSED, sound | {"size": value})
    for key in ("feather", "mixing"):
        for value in [v for v in hostile if v != -1] + [5000]:
            add(f"blend {key} {value!r}", REFUSED, sound | {"blend": sound["blend"] | {key: value}})
    for key, value in (
        ("patch", 0), ("patch", "8"), ("patch", [1, 2, 3]), ("patch", 1e30), ("overlap", 8), ("overlap", 99),
        ("tolerance", -1), ("tolerance", float("nan")), ("tolerance", {}), ("magic", 1),
        ("channel_weights", [float("nan")]),
        ("channel_weights", "1"), ("channel_weights", [0, 0, 0]), ("isometries", 9), ("isometries", [9]),
        ("search", 3), ("patch", 700), ("repeat_penalty", True),
    ):  # fmt: skip
        add(f"{key}={value!r}", REFUSED, sound | {"parameters": sound["parameters"] | {key: value}})
    for value in hostile:
        add(f"inputs {value!r}", EITHER, sound | {"inputs": value})
        add(f"extend {value!r}", REFUSED, sound | {"extend": value})
        add(f"exemplar {value!r}", REFUSED, sound | {"exemplars": [value]})
        for key in ("crop", "scale", "avoid", "alpha", "magnify"):
            add(f"{key} {value!r}", EITHER, sound | {"inputs": {key: value}})
        add(f"depth {value!r}", REFUSED, sound | {"depth": value})
        add(f"heal {value!r}", REFUSED, sound | {"heal": value})
        add(f"grown hole {value!r}", REFUSED, sound | {"heal": {"mask": "alpha", "grow": value}})
        add(f"edge {value!r}", REFUSED, sound | {"heal": {"mask": "alpha", "grow": 0}, "edge": value})
    add("extend far", REFUSED, sound | {"extend": [1 << 30, 1 << 30, 1 << 30, 1 << 30]})
    add("another hash", REFUSED, sound | {"exemplars": [sound["exemplars"][0] | {"sha256": "0" * 64}]})
    add("hash number", REFUSED, sound | {"exemplars": [sound["exemplars"][0] | {"sha256": 7}]})
    add("two exemplars", REFUSED, sound | {"exemplars": sound["exemplars"] * 2})
    add("start", REFUSED, sound | {"start": "00"})
    add("guide", REFUSED, sound | {"guide": "00"})
    return found


_maps()
