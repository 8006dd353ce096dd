"""Arguments of every kind: what is meant is used, all else is refused in one line, nothing is dropped or misread."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import intarsia as ia
from intarsia.foundation.params import parameters
from intarsia.model import Exemplar
from intarsia.tasks.completion import dilated_hole
from intarsia.testing.cases import texture

SMALL = texture(24, 20, 3, 4)
SIDE = ia.ImageQuilting(patch=12)


class Strange:
    """Of no kind that anything is meant to be; what it says of itself has two lines."""

    def __repr__(self) -> str:
        return "strange\nindeed"


WRONG: dict[str, Any] = {
    "None": None, "class": ia.ImageQuilting, "text": "24", "truth": True, "fraction": 2.5, "nan": math.nan,
    "infinite": math.inf, "strange": Strange(), "dict": {"a": 1}, "array": np.zeros((3, 4, 5, 2)), "complex": 1j,
    "list": [None, "x"], "bytes": b"24", "vast": 10**400, "function": lambda: 0, "negative": -3,
}  # fmt: skip
"""What no argument below takes, but where `TAKEN` says so."""


def made() -> ia.Synthesis:
    return ia.synthesize(SMALL, 24, SIDE, run=ia.Run(1))


def hole() -> Any:
    return np.pad(np.ones((3, 4), bool), ((1, 20), (1, 15)))


def weave() -> ia.Weave:
    return ia.weave(SMALL, ia.Repeat())


FLOW = np.zeros((24, 24, 2))
LABELS = ia.Plane(np.zeros((24, 24), np.uint8), "label")

METHODS = [n for n in ia.__all__ if hasattr(getattr(ia, n), "slug") and n != "Auto"]

GIVEN: dict[str, tuple[Callable[..., object], dict[str, Any], str]] = {
    "synthesize": (ia.synthesize, {"exemplar": SMALL, "size": 24, "method": SIDE}, "seed wrap start guide blend run"),
    "extend": (ia.extend, {"picture": SMALL, "margins": ia.Margins(1), "method": SIDE}, "sources seed wrap blend run"),
    "heal": (ia.heal, {"picture": SMALL, "hole": hole(), "method": SIDE}, "sources grow seed wrap run"),
    "tile": (ia.tile, {"image": SMALL, "method": SIDE}, "axes band size sources seed run"),
    "warm": (lambda methods="repeat", **v: ia.warm(methods, **v), {}, "methods run"),
    "weave": (ia.weave, {"exemplar": SMALL, "method": ia.Repeat()}, "seed blend"),
    "tileset": (ia.tileset, {"image": SMALL, "tiles": 16}, "size seed run"),
    "Weave.to_tiff": (lambda **v: weave().to_tiff(**v), {"path": "o.tif", "shape": 32}, "origin tile dask run"),
    "advect": (ia.advect, {"made": made, "flow": FLOW}, "frame coarsest method run"),
    "repair": (ia.repair, {"made": made}, "passes run"),
    "report": (ia.report, {"made": made}, "name"),
    "score": (ia.score, {"exemplar": SMALL, "output": SMALL}, "wrap"),
    "magnified": (ia.magnified, {"exemplar": Exemplar.of(SMALL), "times": 2}, ""),
    "proposed": (ia.proposed, {"exemplar": Exemplar.of(SMALL)}, "strength"),
    "normal_of": (ia.normal_of, {"height": ia.Plane(SMALL[:, :, 0], "data")}, "strength"),
    "height_of": (ia.height_of, {"normal": ia.Plane(SMALL, "normal")}, ""),
    "for_engine": (ia.for_engine, {"exemplar": Exemplar.of(SMALL), "engine": "unreal"}, ""),
    "read": (ia.read, {"path": "sample:tiles"}, "mask alpha height"),
    "write": (ia.write, {"path": "o.png", "picture": SMALL}, "depth recipe"),
    "Synthesis.render": (lambda **v: made().render(**v), {}, "plane feather finish box run"),
    "Auto": (ia.Auto, {}, "trials given needs"),
    "Blend": (ia.Blend, {}, "feather mixing finish"),
    "Canvas": (ia.Canvas, {"height": 5, "width": 5}, "wrap start guide rim"),
    "Exemplar": (Exemplar, {"planes": {"albedo": ia.Plane(SMALL)}}, "usable toroidal name"),
    "Exemplar.of": (Exemplar.of, {"pixels": SMALL}, "usable toroidal name"),
    "Guide": (ia.Guide, {"source": LABELS, "target": LABELS}, "weight reach"),
    "Levelling": (ia.Levelling, {}, "radius strength"),
    "Plane": (ia.Plane, {"pixels": SMALL}, "kind transfer meta"),
    "Run": (ia.Run, {}, "threads step cancel"),
    "SourceMap": (ia.SourceMap, {"yx": np.zeros((3, 4, 2), np.int32)}, "which wrap"),
    **{name: (getattr(ia, name), {}, " ".join(p.name for p in parameters(getattr(ia, name)))) for name in METHODS},
}
"""What is called, arguments that are right, and others that may be given; each in turn is one of `WRONG`."""


def calling(name: str, argument: str) -> Callable[[Any], object]:
    call, right, _ = GIVEN[name]
    return lambda v: call(**{k: x() if x is made else x for k, x in right.items() if k != argument}, **{argument: v})


CALLS: dict[str, Callable[[Any], object]] = {
    f"{name} {argument}": calling(name, argument)
    for name, (_, right, more) in GIVEN.items()
    for argument in (*right, *more.split())
} | {
    "Weave slice": lambda v: weave()[v],
    "Weave.plane": lambda v: weave().plane(v),
    "analyze": ia.analyze,
    "Analysis.overlay": lambda v: ia.analyze(SMALL).overlay(v),
    "flattened": ia.flattened,
    "Exemplar plane": lambda v: Exemplar({"albedo": v}),
    "Field": lambda v: ia.Field(v).at(np.arange(2), np.arange(3)),
    "Margins": lambda v: ia.Margins(left=v),
    "SourceMap.load": ia.SourceMap.load,
    "SourceMap.save": lambda v: made().map.save(v),
    "SourceMap.window": lambda v: made().map.window(v),
}


LEFT_OUT = {
    f"{name} {argument}"
    for name, arguments in {
        "synthesize": "size start guide blend run", "extend": "margins blend run", "heal": "grow run",
        "tile": "band size run", "tileset": "size run", "weave": "blend", "warm": "run",
        "Weave.to_tiff": "tile dask run",
        "advect": "frame method run", "repair": "run", "read": "mask", "write": "depth recipe",
        "Synthesis.render": "plane feather finish box run", "Canvas": "start guide rim", "Exemplar": "usable",
        "Exemplar.of": "usable toroidal name", "Run": "threads step cancel", "SourceMap": "which",
        **{n: " ".join(p.name for p in parameters(getattr(ia, n)) if p.default is None) for n in METHODS},
    }.items()
    for argument in arguments.split()
}  # fmt: skip
"""Where None means what is left out."""

NUMBERS = "float", "price", "field", "levels"
TAKEN: dict[str, set[str]] = {
    **{name: {"text"} for name in ("Exemplar name", "Exemplar.of name", "write recipe", "SourceMap.save")},
    **{name: {"text"} for name in ("report name", "Weave.to_tiff path")},
    **{name: {"truth"} for name in ("Exemplar toroidal", "Exemplar.of toroidal")},
    **{name: {"None"} for name in ("score map", "score wrap")},
    **{name: {"vast"} for name in ("Margins", "Canvas rim")},
    "Plane meta": {"dict"}, "Run step": {"function", "class"}, "Field": {"fraction", "negative"},
    "Guide weight": {"fraction"},
    **{f"{name} strength": {"fraction", "negative"} for name in ("proposed", "normal_of")},
    **{f"{name} angle": {"fraction", "negative"} for name in ("Correction2008", "ParallelControllable")},
    **{f"{name} kappa": {"fraction", "infinite"} for name in ("Correction2008", "ParallelControllable")},
    **{
        f"{name} {p.name}": {"fraction"}
        for name in METHODS for p in parameters(getattr(ia, name))
        if p.kind in NUMBERS and p.name not in ("angle", "kappa") and (p.high or 0) > 2.5
    },
}  # fmt: skip
"""Values of `WRONG` that are right here."""


@pytest.mark.parametrize("call", CALLS)
def test_a_wrong_argument_is_refused_in_one_line(call: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is given in place of what is meant: never a traceback of another kind, never silence."""
    monkeypatch.chdir(tmp_path)
    right = TAKEN.get(call, set()) | ({"None"} if call in LEFT_OUT else set())
    for name, value in WRONG.items():
        if name in right:
            continue
        try:
            CALLS[call](value)
        except ia.IntarsiaError as e:
            told = str(e)
        else:
            pytest.fail(f"{name} was taken")
        assert "\n" not in told, name
        assert len(told) < 600, name


def test_every_function_is_in_the_table() -> None:
    """And every class whose arguments are the caller's; names of words, errors and results need no line."""
    results = {"Analysis", "Box", "Score", "Synthesis", "TileSet", "Weave", "Kind", "Mixing", "Wrap"}
    calls = {call.split()[0].split(".")[0] for call in CALLS}
    errors = {n for n in ia.__all__ if isinstance(getattr(ia, n), type) and issubclass(getattr(ia, n), Exception)}
    bare = {n for n in METHODS if not parameters(getattr(ia, n))}
    assert calls | results | errors | bare == set(ia.__all__)


@pytest.mark.parametrize(
    "size",
    [
        24, 24.0, np.int64(24), np.uint8(24), np.float64(24.0), np.float32(24), np.array(24), Fraction(24), (24, 24),
        [24, np.int32(24)], (24.0, np.uint16(24)), np.array([24, 24]), np.array([24.0, 24.0]),
    ],
    ids=repr,
)  # fmt: skip
def test_sizes_are_whole_numbers_of_any_type(size: Any) -> None:
    out = ia.synthesize(SMALL, size, SIDE, run=ia.Run(1))
    assert out.render().pixels.shape == (24, 24, 3)
    assert out.recipe["size"] == [24, 24]
    assert ia.weave(SMALL, ia.Repeat()).to_dask(size).shape == (24, 24, 3)


@pytest.mark.parametrize(
    "size",
    [
        "24", b"24", ("24", "20"), True, (True, 24), np.True_, 24.7, (24.7, 20.2), math.inf, (math.inf, 5), math.nan,
        (np.nan, 5), (24, 24, 3), (24,), {24, 25}, {24: 1, 25: 2}, Decimal(24), np.array([24.5, 24]),
        np.array([[24, 24]]), pytest.param(iter((24, 24)), id="iterator"),
    ],
    ids=repr,
)  # fmt: skip
def test_what_is_no_size_is_refused(size: Any) -> None:
    """Text, truth values, fractions; nothing is cut to whole numbers."""
    with pytest.raises(ia.ParameterError, match=r"^size=.* is not allowed; give \(height, width\) in whole") as caught:
        ia.synthesize(SMALL, size, SIDE)
    assert "\n" not in str(caught.value)
    with pytest.raises(ia.ParameterError, match=r"^shape=.* is not allowed"):
        ia.weave(SMALL, ia.Repeat()).to_tiff("o.tif", size)


def test_other_whole_numbers_are_of_any_type_too() -> None:
    assert ia.ImageQuilting(patch=np.int64(12), overlap=4.0).patch == 12
    assert ia.Run(np.int16(2)).workers == 2
    assert ia.Blend(np.float32(3)).feather == 3
    assert ia.Margins(right=np.int64(5)) == ia.Margins(right=5.0) == ia.Margins(right=5)
    assert ia.synthesize(SMALL, 24, SIDE, seed=np.uint64(2**64 - 1)).recipe["seed"] == 2**64 - 1
    for call in (lambda: ia.ImageQuilting(patch=np.True_), lambda: ia.Run("2"), lambda: ia.Margins(left=2.5)):
        with pytest.raises(ia.ParameterError, match=r"not allowed|give 1 to 1024"):
            call()


def test_an_exemplar_is_given_what_is_named() -> None:
    """Its mask and the new one both hold; without anything it stays what it is."""
    first = Exemplar.of(SMALL, usable=np.indices((24, 20))[0] > 3, name="first")
    assert Exemplar.of(first) is first
    right = np.indices((24, 20))[1] > 5
    again = Exemplar.of(first, usable=right, toroidal=True, name="again")
    assert (again.usable == (first.usable & right)).all()
    assert (again.toroidal, again.name, first.toroidal, first.name) == (True, "again", False, "first")
    assert (Exemplar.of(again, toroidal=False).toroidal, Exemplar.of(again, name="x").name) == (False, "x")
    assert Exemplar.of(again, name="x").toroidal
    assert again.digest != first.digest
    assert (ia.synthesize(again, 24, ia.PatchSampling(patch=8)).map.yx[..., 1] > 5).all()


def test_masked_pixels_are_not_used() -> None:
    """Of one channel or all, under NaN, on planes of other sizes; where masks mean nothing they are refused."""
    masked = np.ma.array(SMALL, mask=np.zeros(SMALL.shape, bool))
    assert Exemplar.of(masked).usable is None
    masked.mask[:8, :, 1] = True
    e = Exemplar.of(masked)
    assert (e.usable == (np.indices((24, 20))[0] >= 8)).all()
    assert (ia.synthesize(masked, 24, ia.PatchSampling(patch=8)).map.yx[..., 0] >= 8).all()
    heights = np.where(np.indices((24, 20))[1] < 4, np.nan, 0.5).astype(np.float32)
    both = Exemplar.of({"albedo": masked, "height": np.ma.masked_invalid(heights)}, usable=np.ones((24, 20)))
    assert (both.usable == (e.usable & ~np.isnan(heights))).all()
    for times, hidden in ((2, np.indices((48, 40))[0] == 17), (0.5, np.indices((12, 10))[0] == 4)):
        plane = np.ma.array(np.ones(hidden.shape, np.float32), mask=hidden)
        found = np.flatnonzero(~Exemplar.of({"albedo": SMALL, "height": plane}).usable.any(axis=1))
        assert found.tolist() == ([8] if times == 2 else [8, 9])
    assert ia.Plane(np.ma.array(SMALL)).pixels.shape == SMALL.shape
    for call in (lambda: ia.Plane(masked), lambda: ia.write("o.png", masked), lambda: ia.heal(SMALL, masked[..., 1]),
                 lambda: ia.Field(masked[..., 1]), lambda: Exemplar.of(SMALL, usable=masked[..., 1])):  # fmt: skip
        with pytest.raises(ia.InputError, match="masked"):
            call()


def picture(mode: str) -> Image.Image:
    """A picture of Pillow of any mode, with something transparent where it can be."""
    rgba = np.dstack([SMALL, np.where(np.indices((24, 20))[0] < 9, 90, 255)]).astype(np.uint8)
    if mode.startswith("I;16"):
        deep = (SMALL[:, :, 0].astype(np.uint16) * 257).astype(">u2" if mode[-1] == "B" else "<u2")
        return Image.frombytes(mode, (20, 24), deep.tobytes())
    if mode == "LAB":
        return Image.fromarray(SMALL).convert("LAB")
    if mode == "PA":
        return Image.fromarray(SMALL).convert("P").convert("PA")
    first = Image.fromarray(rgba if mode in ("RGBA", "RGBa", "LA", "La") else SMALL)
    return (first.convert("LA") if mode == "La" else first).convert(mode)


@pytest.mark.parametrize("mode", [
    "1", "P", "PA", "L", "LA", "La", "RGB", "RGBA", "RGBa", "RGBX", "CMYK", "HSV", "YCbCr", "LAB",
])  # fmt: skip
def test_pictures_of_pillow_are_taken_as_it_shows_them(mode: str) -> None:
    """By mode: no palette numbers, inks or hues for light, and no fourth channel that is no opacity."""
    image = picture(mode)
    assert image.mode == mode
    opaque = {"1": "L", "L": "L", "LA": "LA", "La": "LA", "RGBA": "RGBA", "RGBa": "RGBA", "PA": "RGBA"}.get(mode, "RGB")
    shown = np.asarray(image.convert(opaque))
    assert (Exemplar.of(image).base.pixels == shown).all()
    assert (ia.Plane(image).pixels == shown).all()
    assert (np.asarray(ia.synthesize(image, (24, 20), ia.Repeat()).render()) == shown).all()
    if mode not in ("LAB", "La"):  # which Pillow makes of few others
        marked = Image.fromarray(np.uint8(255) * hole()).convert("RGB" if mode != "1" else "1").convert(mode)
        assert ia.heal(SMALL, marked, SIDE).recipe["start"] == ia.heal(SMALL, hole(), SIDE).recipe["start"]


def test_depth_of_pillow_is_kept_and_transparent_colours_are_seen() -> None:
    deep = SMALL[:, :, 0].astype(np.uint16) * 257
    for mode in ("I;16", "I;16L", "I;16B", "I;16N"):
        assert (ia.Plane(picture(mode)).pixels == deep).all()
    assert ia.Plane(Image.fromarray(deep.astype(np.int32))).pixels.dtype == np.uint16
    assert (ia.Plane(Image.fromarray(deep.astype(np.int32))).pixels == deep).all()
    assert ia.Plane(Image.fromarray(deep.astype(np.float32) / 7)).pixels.dtype == np.float32
    for numbers in (deep.astype(np.int32) - 9000, deep.astype(np.int32) * 2):
        with pytest.raises(ia.InputError, match=r"^a picture of Pillow's mode I holds .*; give 0 to 65535, or mode F"):
            ia.Plane(Image.fromarray(numbers))
    palette = picture("P")
    assert (ia.Plane(palette, "label").pixels == np.asarray(palette)).all()
    assert ia.Plane(picture("1"), "label").pixels.dtype == bool
    palette.info["transparency"] = int(np.asarray(palette)[0, 0])
    assert (ia.Plane(palette).pixels == np.asarray(palette.convert("RGBA"))).all()
    assert ia.Plane(palette).pixels[..., 3].min() == 0
    gray = picture("I;16")
    gray.info["transparency"] = int(deep[0, 0])
    assert ((ia.Plane(gray).pixels[..., 1] == 0) == (deep == deep[0, 0])).all()
    strange = picture("L")
    strange._mode = "XYZ"
    with pytest.raises(ia.InputError, match=r"^a picture of Pillow's mode XYZ is not supported; convert it, to RGB"):
        ia.Plane(strange)


def test_holes_are_what_is_not_black() -> None:
    """Whatever picture they are drawn in: 256 of 65535, a little gray, red, half opacity."""
    wanted = ia.heal(SMALL, hole(), SIDE, run=ia.Run(1)).recipe["start"]
    white = np.uint8(255) * hole()
    many = [
        white, hole().astype(int), hole() * np.uint16(256), hole() * 0.3, hole() * np.float16(1e-3), hole()[:, :, None],
        np.dstack([white] * 3), np.dstack([white, 0 * white, 0 * white]), np.dstack([white // 9] * 3), hole().tolist(),
        np.dstack([255 + 0 * white] * 3 + [white]), np.dstack([255 + 0 * white, white]), ia.Plane(white), -1 * hole(),
        np.dstack([white] * 3 + [255 + 0 * white]), np.asfortranarray(white), Image.fromarray(white),
    ]  # fmt: skip
    for number, given in enumerate(many):
        assert ia.heal(SMALL, given, SIDE, run=ia.Run(1)).recipe["start"] == wanted, number
    assert (dilated_hole(hole() * np.uint16(256), 0) == hole()).all()
    assert (Exemplar.of(SMALL, usable=hole() * np.uint16(256)).usable == hole()).all()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (np.where(hole(), np.nan, 0), "the hole's mask holds NaN, which neither marks a pixel nor leaves it"),
        (np.zeros((24, 20, 5)), r"the hole's mask has the shape \(24, 20, 5\); give \(height, width\), or a gray"),
        (np.zeros((3, 24, 20)), r"the hole's mask has the shape \(3, 24, 20\)"),
        (np.zeros(24), r"the hole's mask has the shape \(24,\)"),
        ("hole.png", "the hole's mask is the name of a file; give its pixels"),
        (Path("hole.png"), "the hole's mask is the name of a file; give its pixels"),
        (None, "the hole's mask is of type object; give truth values"),
        (np.zeros((24, 20), complex), "the hole's mask is of type complex128"),
        ([[1, 0], [1]], "the hole's mask: list is no array of pixels"),
        (np.ones((20, 24)), "the hole's mask is 24x20 px, exemplar 1 20x24; make them equal"),
    ],
)
def test_what_marks_no_hole_is_refused_in_one_line(given: Any, message: str) -> None:
    with pytest.raises(ia.InputError, match=f"^{message}") as caught:
        ia.heal(SMALL, given, SIDE)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("error", [KeyError("x"), AttributeError("no such\nthing"), ZeroDivisionError()])
def test_a_flow_that_fails_is_named_in_one_line(error: Exception) -> None:
    def failing(y: Any, x: Any) -> Any:
        raise error

    with pytest.raises(ia.InputError, match=rf"^the function {__name__}.*failing gives no flow: ") as caught:
        ia.advect(made(), failing)
    assert caught.value.__cause__ is error
    assert "\n" not in str(caught.value)


def test_what_is_said_of_something_is_one_short_line() -> None:
    from intarsia.foundation import said

    class Broken:
        def __str__(self) -> str:
            raise RuntimeError

    assert said("a\nb\x1b[31m" + "c" * 400).startswith("a b?[31mccc")
    assert len(said("x" * 1000)) == 100
    assert said(Broken()) == "Broken"
    assert said(KeyError("x")) == "KeyError: 'x'"
