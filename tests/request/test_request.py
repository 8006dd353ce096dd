"""A request is the same in words, JSON, recipe and Python; a field of it is declared in one line."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import pytest

import intarsia
from intarsia.cli.verbs import read_argv
from intarsia.foundation import InputError, ParameterError
from intarsia.foundation.params import KINDS
from intarsia.methods import METHODS, method_class
from intarsia.request import (
    FIELDS,
    Request,
    fields_of_verb,
    from_json,
    from_recipe,
    inputs_of,
    parameters_of_verb,
    repeated,
    to_argv,
    to_json,
    values_of,
)
from intarsia.request.field import Field, Kind, Whole
from intarsia.request.fields import EVERY
from intarsia.request.python import to_python

NEEDED: dict[str, dict[str, Any]] = {
    "heal": {"holes": ("h.png",)},
    "paint": {"labels": ("l.png",), "target": "t.png"},
    "weave": {"size": (70, 60)},
    "render": {"saved": "m.npz", "out": "o.png"},
    "replay": {"picture": "p.png", "out": "o.png"},
    "score": {"output": "g.png"},
    "tileset": {"out": "tiles"},
}
"""What a verb cannot do without, beside its exemplars."""

BESIDE = {
    "by": {"trials": 2},
}  # fmt: skip
"""What must be asked for, so that a field may be."""

VALUES = {
    "size": (40, 30), "rectangle": (1, 2, 30, 20), "scale": 3, "colour": (1, 2, 250), "seed": 7, "flag": True,
    "named": ("total", 0.5), "float": 1.5, "exemplar": "b.png", "image": "i.png",
}  # fmt: skip
NAMED = {
    "maps": ("normal", "n.png"), "pictures": ("zoom", "z.png"), "page": "r.html", "called": ("a.png", "Bark"),
    "many": (1, 2, 3, 9), "origin": (-7, 12), "packed": "R=ao,G=roughness",
    "sheet": "s.png", "dask": "local",
}  # fmt: skip


def some(field: Field) -> Any:
    """A value of a field that is not the usual one."""
    kind: Kind = field.kind
    if field.name in NAMED:
        value = NAMED[field.name]
    elif kind.choices and not isinstance(kind, Whole) and kind.name == "choice":
        value = next(choice for choice in kind.choices[::-1] if choice != field.default)
    elif isinstance(kind, Whole):
        value = kind.low + 3
    else:
        value = VALUES.get(kind.name, "f.png")
    return (value,) if field.many else value


def plain(verb: str, **more: Any) -> Request:
    return Request(verb, **{"files": ("a.png", "c.png")[: 1 + (verb == "grow")], **NEEDED.get(verb, {}), **more})


def asked(verb: str) -> list[Request]:
    """Requests of a verb: the plain one, and one for each field; a document stands for others."""
    left_out = ("saved", "picture", "output", "trials", "explain", "document")
    fields = [f for f in fields_of_verb(verb) if f.name not in left_out]
    given = [BESIDE.get(f.name, {}) | {f.name: some(f)} for f in fields if f.name != "files"]
    return [plain(verb), *(plain(verb, **one) for one in given)]


@pytest.mark.parametrize("verb", sorted(EVERY))
def test_words_say_all_that_is_asked_for(verb: str) -> None:
    for request in asked(verb):
        for joined in (False, True):
            assert read_argv(to_argv(request, joined)) == request


@pytest.mark.parametrize("verb", sorted(EVERY))
def test_so_does_json(verb: str) -> None:
    for request in asked(verb):
        arguments = {f.name: getattr(request, f.name) for f in fields_of_verb(verb) if not f.flags}
        if request.pictures == ():  # no job names them
            assert from_json(verb, to_json(request), **arguments) == request


def test_json_may_hold_lists_and_numbers() -> None:
    told = {"size": [40, 30], "crop": [1, 2, 30, 20], "seed": 7, "patch": [8, 6], "flatten": True, "wrap": None}
    words = ["grow", "a.png", "--size=40x30", "--crop=1,2,30,20", "--seed=7", "--patch=8x6", "--flatten"]
    assert from_json("grow", told, files=("a.png",)) == read_argv(words)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"size": "x"}, "size: x is no size"),
        ({"feather": 9999}, "feather: 9999 is not in the range 0<=x<=1024."),
        ({"feather": "wide"}, "feather: 'wide' is not a valid integer range."),
        ({"mixing": "other"}, "mixing: 'other' is not one of 'mean', 'source'."),
        ({"flatten": 1}, "flatten is yes or no"),
        ({"crop": [0, 0, 5, 5], "toroidal": True}, "--toroidal does not go with --crop"),
    ],
)
def test_what_json_cannot_hold_is_refused_in_the_words_of_the_command(given: dict[str, Any], said: str) -> None:
    with pytest.raises(ParameterError) as refused:
        from_json("grow", given, files=("a.png",))
    assert said in str(refused.value)
    if "flatten" not in given:
        words = [f"--{name}" if value is True else f"--{name}={value}" for name, value in given.items()]
        with pytest.raises((ParameterError, click.UsageError)) as also:
            read_argv(["grow", "a.png", *(w.replace("[", "").replace("]", "").replace(" ", "") for w in words)])
        assert said.partition(": ")[2] in str(also.value)


@pytest.mark.parametrize("slug", list(METHODS))
def test_the_same_picture_is_asked_for_once_more(slug: str) -> None:
    """The method is named with all that it has; what bears on nothing in the picture is left out."""
    request = plain("grow", trials=3, page="r.html", threads=2, even_tone=0, crop=(0, 0, 9, 9))
    method = method_class(slug)()
    again = repeated(request, [{"albedo": "a.png", "normal": "n.png", "mask": "m.png"}], method, 5, out="o.png")
    assert (again.files, again.maps, again.masks) == (("a.png",), (("normal", "n.png"),), ("m.png",))
    assert (again.trials, again.page, again.threads) == (None, None, None)
    assert (again.seed, again.even_tone, again.crop, again.out) == (5, 0, (0, 0, 9, 9), "o.png")
    assert read_argv(to_argv(again)).chosen == method


@pytest.mark.parametrize("verb", ["grow", "extend", "heal", "paint", "tile", "weave"])
def test_every_parameter_is_written_as_it_is_read(verb: str) -> None:
    values = {
        "int": 3, "float": 0.5, "extent": (8, 6), "weights": (0.5, 0.25, 0.25), "levels": (0.0, 0.5), "price": "inf",
        "pins": ((1, 2, 3, 4, 5), (6, 7, 8, 9, 10)), "vectors": ((20.25, 0.0), (1.5, 9.0)), "isometries": (0, 3),
        "field": 0.5, "picture": "z.png",
    }  # fmt: skip
    for name, (p, owners) in parameters_of_verb(verb).items():
        value = p.choices[-1] if p.kind == "choice" else values[p.kind]
        request = plain(verb, method=owners[0], parameters={name: value})
        read = read_argv(to_argv(request)).parameters
        if value != p.default:
            assert KINDS[p.kind].text(value)
            assert read == {name: value} or {**read} == {name: float(value)}  # type: ignore[arg-type]


def test_a_recipe_holds_no_path_and_only_what_is_not_usual() -> None:
    assert inputs_of(plain("grow", threads=3, page="r.html", maps=(("normal", "n.png"),))) == {}
    request = plain("grow", crop=(1, 2, 3, 4), scale=4, avoid=(255, 0, 1), alpha="mask", weights=(("normal", 2.0),))
    assert inputs_of(request) == {
        "crop": [1, 2, 3, 4], "scale": "1/4", "avoid": "#ff0001", "alpha": "mask", "weights": {"normal": 2.0},
    }  # fmt: skip


RECIPE: dict[str, Any] = {
    "method": "image-quilting", "parameters": {"patch": [8, 6]}, "size": [40, 30], "seed": 9, "wrap": "x",
    "blend": {"feather": 2, "mixing": "mean"}, "exemplars": [{"sha256": "0" * 64}],
}  # fmt: skip


def test_a_recipe_is_a_request_again() -> None:
    """What is given now goes before what it says."""
    was = plain("grow", crop=(1, 2, 3, 4), scale=4, avoid=(255, 0, 1), weights=(("normal", 2.0),), magnify=2)
    given = Request("replay", picture="p.png", out="o.png", files=("a.png", "c.png"), scale=2)
    again = from_recipe(RECIPE | {"inputs": inputs_of(was), "depth": "16"}, given, "the recipe")
    assert (again.verb, again.size, again.seed, again.wrap, again.feather) == ("grow", (80, 60), 9, "x", 2)
    assert {f.name: getattr(again, f.name) for f in FIELDS if f.of_exemplars} == {
        f.name: 2 if f.name == "scale" else getattr(was, f.name) for f in FIELDS if f.of_exemplars
    }
    assert (again.depth, again.out, again.method) == ("16", "o.png", "image-quilting")
    assert values_of(again.chosen)["patch"] == (6, 8)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "change",
    [
        {"seed": "random"}, {"seed": "7"}, {"seed": None}, {"size": 40}, {"size": [40, "x"]}, {"wrap": "round"},
        {"start": "0", "rim": "wide"}, {"repair": 1.5}, {"edge": -1, "heal": {"grow": 1}}, {"heal": {}}, {"tile": {}},
        {"extend": [1, 2, 3]}, {"extend": [1, 2, 3, "x"]}, {"guide": {"weight": 1}}, {"exemplars": []},
        {"inputs": {"crop": [1, 2, 3]}}, {"inputs": {"magnify": 0}}, {"inputs": 3}, {"depth": "12"}, {"blend": {}},
    ],
    ids=str,
)  # fmt: skip
def test_a_damaged_recipe_is_called_so(change: dict[str, Any]) -> None:
    given = Request("replay", picture="p.png", out="o.png", files=("a.png",))
    with pytest.raises(InputError, match=r"^the recipe is damaged|^the recipe cannot be followed"):
        from_recipe(RECIPE | change, given, "the recipe")


def test_python_runs_the_command_where_a_call_would_say_less() -> None:
    request = plain("heal", masks=("u.png",), out="whole.png")
    _, _, line = to_python(request, {}).splitlines()
    words = ast.literal_eval(line.removeprefix("subprocess.run(").removesuffix(", check=True)"))
    assert read_argv(words[1:]) == request


TOLD = "Give it a tint. It is faint."
LINE = f'    tint: str | None = option(Colour(), "--tint", "{TOLD}", "grow", "of_exemplars")\n'
SCRIPT = """
from click.testing import CliRunner
from intarsia.cli import cli
from intarsia.cli.verbs import read_argv
from intarsia.request import to_argv, to_line
from intarsia.request import from_json, to_json
from intarsia.request.python import to_python
from intarsia.request import from_recipe, inputs_of
from intarsia.request import Request
from intarsia.studio import requests

help = CliRunner().invoke(cli, ["grow", "--help"]).stdout
assert "--tint #RRGGBB" in help and "Give it a tint." in help
option = requests.options("grow")["tint"]
assert (option["kind"], option["help"]) == ("colour", "Give it a tint. It is faint.")
assert "tint" not in requests.options("heal")
request = read_argv(["grow", "a.png", "--tint", "#0102ff"])
assert request.tint == (1, 2, 255)
assert to_line(request) == "intarsia grow a.png --tint '#0102ff'"
assert from_json("grow", to_json(request), files=("a.png",)) == request
assert inputs_of(request) == {"tint": "#0102ff"}
recipe = %r | {"inputs": inputs_of(request)}
assert from_recipe(recipe, Request("replay", files=("a.png",), out="o.png"), "it").tint == (1, 2, 255)
assert "'--tint=#0102ff'" in to_python(request, {})
"""


def test_a_field_is_one_line_in_one_file(tmp_path: Path) -> None:
    """Help, page, words, JSON, recipe and Python have it then."""
    package = Path(intarsia.__file__).parent
    shutil.copytree(package, tmp_path / "intarsia", ignore=shutil.ignore_patterns("static", "__pycache__"))
    table = tmp_path / "intarsia" / "request" / "fields.py"
    before = "    magnify: int = option("
    text = table.read_text(encoding="utf-8")
    assert text.count(before) == 1
    table.write_text(text.replace(before, LINE + before), encoding="utf-8")
    env = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", SCRIPT % RECIPE], capture_output=True, text=True, env=env, timeout=60)
    assert done.returncode == 0, done.stderr
