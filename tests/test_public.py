"""What the package shows: its names, what each method claims, and one meaning for each parameter's name."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import intarsia as ia
from intarsia.foundation import IntarsiaError, params
from intarsia.methods import METHODS, Ability, make, method_class, recipe_settings
from intarsia.model.image import Plane

A = Ability

OBVIOUS = {"height", "width"}

CLAIMS: dict[str, set[Ability]] = {
    "ashikhmin": {A.WRAP, A.START, A.MASK, A.SEVERAL},
    "best-tile": {A.WRAP, A.MASK, A.WINDOW},
    "efros-leung": {A.WRAP, A.START, A.MASK, A.ISOMETRIES, A.SEVERAL},
    "gap-filling": {A.MASK},
    "graphcut": {A.WRAP, A.START, A.MASK, A.GUIDE, A.ISOMETRIES, A.SEVERAL},
    "image-quilting": {A.WRAP, A.START, A.MASK, A.GUIDE, A.ISOMETRIES, A.SEVERAL},
    "patch-sampling": {A.WRAP, A.START, A.MASK, A.GUIDE, A.ISOMETRIES, A.SEVERAL},
    "parallel-controllable": {A.WRAP, A.MASK, A.GUIDE, A.WINDOW},
    "correction-2008": {A.WRAP, A.MASK, A.GUIDE, A.WINDOW},
    "near-regular": {A.WRAP, A.MASK, A.WINDOW},
    "random-tiling": {A.WRAP, A.START, A.MASK, A.ISOMETRIES, A.SEVERAL},
    "raster-quilting": {A.MASK},
    "repeat": {A.WINDOW},
    "segment-based": {A.WRAP, A.MASK},
    "wei-levoy": {A.WRAP, A.START, A.MASK, A.SEVERAL},
}
"""What every method must be able to do; a claim is added here first."""


def test_the_names_for_checkers_are_those_at_run_time() -> None:
    """The imports of the stub, the table of homes and `__all__` name the same things."""
    stub = Path(ia.__file__).with_suffix(".pyi").read_text("utf-8")
    told = [(m[2], m[1]) for line in stub.splitlines() if (m := re.match(r"from \.(\S+) import (.*)", line))]
    homes = {n.partition(" as ")[0]: home for names, home in told for n in names.split(", ")}
    assert homes == ia._HOMES
    assert sorted(homes) == ia.__all__
    assert set(ia.__all__) <= set(dir(ia))
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = ia.nonsense  # type: ignore[attr-defined]
    for name, home in homes.items():
        assert getattr(importlib.import_module(f"intarsia.{home}"), name) is getattr(ia, name)


@pytest.mark.parametrize("name", ia.__all__)
def test_every_name_is_documented(name: str) -> None:
    """A first line that is a sentence; public methods and properties, too."""
    thing = getattr(ia, name)
    told = inspect.getdoc(thing)
    assert told
    assert told.splitlines()[0].endswith((".", ":"))
    assert not told.startswith(f"{name}("), "the docstring that dataclass makes"
    if inspect.isclass(thing):
        for key, value in vars(thing).items():
            shown = not key.startswith("_") and key not in OBVIOUS
            if shown and (inspect.isfunction(value) or isinstance(value, (property, classmethod))):
                assert inspect.getdoc(value), key


def test_importing_the_package_imports_nothing_heavy() -> None:
    """`import intarsia`, its errors, run and boxes, the list of methods and their parameters need no numpy."""
    code = """
import sys, intarsia
intarsia.Box, intarsia.Run, intarsia.IntarsiaError, intarsia.Wrap
from intarsia.foundation import params
from intarsia.methods import METHODS, make, method_class
for slug in METHODS:
    params.parameters(method_class(slug)); make(slug, {})
try:
    make("image-quilting", {"patch": -1})
except intarsia.ParameterError:
    pass
print([m for m in ("numpy", "scipy", "numba", "PIL", "OpenImageIO", "skimage", "click") if m in sys.modules])
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_every_method_claims_what_it_must() -> None:
    assert set(METHODS) == set(CLAIMS)
    for slug, claims in CLAIMS.items():
        assert method_class(slug).supports == frozenset(claims), slug


@pytest.mark.parametrize("slug", METHODS)
def test_a_method_is_a_frozen_dataclass_of_its_parameters(slug: str) -> None:
    """File, class, slug: one name; every field a parameter with help; claims and fields agree."""
    module, name = METHODS[slug]
    cls, file = method_class(slug), module.rpartition(".")[2]
    assert (cls.slug, cls.__module__) == (slug, f"intarsia.{module}")
    assert (slug, name) == (file.replace("_", "-"), file.title().replace("_", ""))
    assert cls.__dataclass_params__.frozen
    assert cls.paper
    assert cls.summary.rstrip(".") == cls.summary > ""
    names = [p.name for p in params.parameters(cls)]
    assert names == [f.name for f in dataclasses.fields(cls)]
    assert ("isometries" in names) == (Ability.ISOMETRIES in cls.supports)
    assert recipe_settings(make(slug, {})) == {p.name: p.default for p in params.parameters(cls)}
    assert make(slug, {}).blend == ia.Blend(4 if slug == "gap-filling" else 0)


@pytest.mark.parametrize("slug", METHODS)
def test_every_parameter_says_what_it_is(slug: str) -> None:
    for p in params.parameters(method_class(slug)):
        assert p.help
        assert p.help[0].islower(), "help follows a name"
        assert not p.help.endswith(".")
        plain = "int", "float", "choice", "extent", "weights", "vectors", "isometries"
        assert p.kind in (*plain, "levels", "price", "pins", *params.OVER)
        assert p.over in (("output", "exemplar") if p.kind in params.OVER else ("",))
        if p.kind == "choice":
            assert p.default in p.choices
        elif p.kind != "isometries":
            assert p.low is not None, p.name
            assert p.high is not None, p.name
        if p.kind == "extent":
            assert p.unit == "px"
        assert p.allowed()


def test_one_name_has_one_meaning_in_all_methods() -> None:
    """One parameter name has one kind, unit and range everywhere."""
    seen: dict[str, tuple[str, params.Parameter]] = {}
    for slug in METHODS:
        for p in params.parameters(method_class(slug)):
            other, q = seen.setdefault(p.name, (slug, p))
            assert replace(p, default=None, help="") == replace(q, default=None, help=""), (
                f"{p.name} of {slug} and of {other}"
            )


def test_patch_methods_tell_pitch_and_footprint() -> None:
    """Every patch method exposes .pitch and .footprint, (rows, columns) px."""
    for slug in METHODS:
        if "patch" in {p.name for p in params.parameters(method_class(slug))}:
            method = make(slug, {"patch": (20, 30)})
            assert method.footprint == (20, 30)
            assert len(method.pitch) == 2


def test_errors_are_one_tree_with_fixed_exit_codes() -> None:
    """One hierarchy, drawn at the top of its file; codes are those of the command line."""
    from intarsia import foundation

    classes = filter(inspect.isclass, vars(foundation).values())
    tree = {c.__name__: c.exit_code for c in classes if issubclass(c, Exception)}
    assert tree == {
        "IntarsiaError": 1, "ParameterError": 2, "InputError": 3, "QualityError": 4, "MissingExtraError": 5,
        "MethodError": 1, "ResourceError": 1, "CancelledError": 130,
    }  # fmt: skip
    for name in tree:
        assert issubclass(getattr(foundation, name), IntarsiaError)
        assert name in (foundation.__doc__ or "")


def test_what_is_printed_is_one_line_without_pixels() -> None:
    """As a shell shows it; within another object, too."""
    exemplar = ia.Exemplar.of(np.arange(1200, dtype=np.uint8).reshape(20, 20, 3), name="moss")
    made = ia.synthesize(exemplar, (30, 40), ia.ImageQuilting(patch=8), seed=5)
    labels = Plane(np.zeros((20, 20), np.uint8), ia.Kind.LABEL)
    assert repr(made) == "<texture: 40x30 px, image-quilting, seed 5>"
    assert repr(made.map) == "<map: 40x30 px, of moss>"
    assert repr(exemplar) == "<exemplar moss: 20x20 px, albedo>"
    assert repr(exemplar.base) == "<plane: 20x20 px, colour, uint8 x 3>"
    for longer in (
        ia.Guide(labels, labels), ia.Canvas(30, 40, start=made.map), ia.analyze(exemplar), ia.score(exemplar, made),
        made.canvas, ia.weave(exemplar, ia.Repeat()),
    ):  # fmt: skip
        assert len(str(longer)) < 250
        assert "array(" not in str(longer)
        assert "\n" not in str(longer)
    assert str(ia.score(exemplar, exemplar)).startswith("<score: ")
