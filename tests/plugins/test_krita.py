"""The plug-in for Krita without Krita: files that it writes, words that it says, what lies where."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import intarsia as ia
from intarsia.methods import METHODS
from intarsia.plugins import HOSTS, install, remove

DEPTHS = {"U8": np.uint8, "U16": np.uint16, "F16": np.float16, "F32": np.float32}
NAME = "intarsia_textures"


class _Anything(ModuleType):
    """A module of Krita or Qt: whatever it is asked for is a class, with what is asked of it at import."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        app = SimpleNamespace(addExtension=lambda extension: None)
        return type(name, (), {"StandardButton": None, "instance": lambda: app, "__init__": lambda self, *_: None})


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The plug-in as it is installed, imported beside stand-ins of Krita and Qt."""
    folder = tmp_path / "pykrita"
    folder.mkdir()
    install("krita", str(folder))
    monkeypatch.syspath_prepend(str(folder))
    qt: Any = ModuleType("PyQt5")
    qt.QtCore, qt.QtGui, qt.QtWidgets = map(_Anything, ("QtCore", "QtGui", "QtWidgets"))
    monkeypatch.setitem(sys.modules, "PyQt5", qt)
    monkeypatch.setitem(sys.modules, "krita", _Anything("krita"))
    importlib.import_module(NAME)
    yield lambda part: importlib.import_module(f"{NAME}.{part}")
    for name in [name for name in sys.modules if name.split(".")[0] == NAME]:
        del sys.modules[name]


def node(model: str = "RGBA", depth: str = "U8", kind: str = "paintlayer") -> Any:
    told = {"colorModel": model, "colorDepth": depth, "colorProfile": "profile", "name": "Wall", "type": kind}
    return SimpleNamespace(**{name: lambda value=value: value for name, value in told.items()})


def drawn(model: str, depth: str, clear: bool) -> np.ndarray[Any, Any]:
    """Pixels as a picture has them: red first, opacity last."""
    draws = np.random.default_rng(3)
    shape = (5, 7, 2 if model == "GRAYA" else 4)
    if depth.startswith("F"):
        pixels = draws.random(shape).astype(DEPTHS[depth]) * 3
        pixels[..., -1] = 1
    else:
        pixels = draws.integers(0, np.iinfo(DEPTHS[depth]).max, shape).astype(DEPTHS[depth])
        pixels[..., -1] = np.iinfo(pixels.dtype).max
    if clear:
        pixels[1, 2, -1] = 3
    return pixels


def held(pixels: np.ndarray[Any, Any]) -> bytes:
    """The bytes of Krita's layer: blue first where numbers are whole."""
    turned = pixels.shape[2] == 4 and pixels.dtype.kind == "u"
    return (pixels[..., [2, 1, 0, 3]] if turned else pixels).tobytes()


@pytest.mark.parametrize("model", ["GRAYA", "RGBA"])
@pytest.mark.parametrize(("depth", "clear"), [*((d, False) for d in DEPTHS), ("U8", True), ("U16", True)])
def test_a_layer_is_written_as_it_is(plugin: Any, tmp_path: Path, model: str, depth: str, clear: bool) -> None:
    """Without opacity where nothing is transparent; other floats go by Krita's own export."""
    layers, pixels = plugin("layers"), drawn(model, depth, clear)
    space = layers.Space(node(model, depth))
    path = tmp_path / f"given{space.suffix}"
    layers.save(space, held(pixels), 7, 5, path)
    found = ia.read(path).base.pixels
    expected = pixels if clear else pixels[..., :-1]
    assert found.dtype == expected.dtype
    assert np.array_equal(found.reshape(expected.shape), expected)


@pytest.mark.parametrize(("model", "depth"), [("GRAYA", "U8"), ("RGBA", "U16"), ("GRAYA", "F32"), ("RGBA", "F32")])
def test_what_was_not_healed_is_transparent(plugin: Any, model: str, depth: str) -> None:
    layers, before = plugin("layers"), drawn(model, depth, clear=False)
    after = before.copy()
    after[2, 3, 0] += 1  # outside the selection: the rim of a flaw
    chosen = np.zeros((5, 7), np.uint8)
    chosen[4, 1] = 255
    made = layers.only_changed(layers.Space(node(model, depth)), held(before), held(after), chosen.tobytes(), 7)
    found = np.frombuffer(made, before.dtype).reshape(before.shape)
    shown = (chosen > 0) | (after != before).any(axis=2)
    assert np.array_equal(found[..., -1] != 0, shown)
    assert found[shown].tobytes() == np.frombuffer(held(after), before.dtype).reshape(before.shape)[shown].tobytes()


def test_layers_that_hold_nothing_to_grow_are_refused(plugin: Any) -> None:
    calling, layers, work = plugin("calling"), plugin("layers"), plugin("work")
    with pytest.raises(calling.Trouble, match=r'"Wall" is CMYKA U8; .* Convert Image Color Space'):
        layers.Space(node("CMYKA"))
    with pytest.raises(calling.Trouble, match="no paint layer"):
        work.chosen_layer(SimpleNamespace(activeNode=lambda: node(kind="grouplayer")))
    with pytest.raises(calling.Trouble, match="No picture"):
        work.chosen_layer(None)
    outside = SimpleNamespace(x=lambda: 50, y=lambda: 0, width=lambda: 9, height=lambda: 9)
    with pytest.raises(calling.Trouble, match="outside"):
        work.example_box(SimpleNamespace(selection=lambda: outside, width=lambda: 50, height=lambda: 40))


def test_a_selection_is_cropped_to_the_canvas(plugin: Any) -> None:
    chosen = SimpleNamespace(x=lambda: -4, y=lambda: 30, width=lambda: 20, height=lambda: 30)
    doc = SimpleNamespace(selection=lambda: chosen, width=lambda: 50, height=lambda: 40)
    assert plugin("work").example_box(doc) == (0, 30, 16, 10)


def test_automatic_fields_are_not_asked_for(plugin: Any) -> None:
    words = plugin("dialogs").options_of
    assert words("tile", {"seed": 1, "axes": "x", "band": 0}) == ["--seed", 1, "--axes", "x"]
    assert words("tile", {"seed": 1, "axes": "x", "band": 9})[-2:] == ["--band", 9]
    assert words("heal", {"seed": 1, "wrap": "none", "grow": -1}) == ["--seed", 1, "--wrap", "none"]
    assert words("heal", {"seed": 1, "wrap": "none", "grow": 0})[-2:] == ["--grow", 0]


def test_methods_are_those_of_the_program(plugin: Any) -> None:
    assert {word for _, word in plugin("dialogs").METHODS} <= {"auto", *METHODS}


def test_krita_finds_the_plug_in_and_its_actions(plugin: Any, tmp_path: Path) -> None:
    about = (tmp_path / "pykrita" / f"{NAME}.desktop").read_text()
    assert f"X-KDE-Library={NAME}\n" in about
    actions = (HOSTS / "krita" / NAME / f"{NAME}.action").read_text()
    assert re.findall(r'<Action name="(\w+)"', actions) == [f"intarsia_{verb}" for verb in plugin("dialogs").TITLES]
    remove("krita", str(tmp_path / "pykrita"))
    assert list((tmp_path / "pykrita").iterdir()) == []
