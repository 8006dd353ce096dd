"""The plug-in for GIMP without GIMP: names of maps, files, masks, fields. The rest: tests/programs/gimp.py."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest

from intarsia import files
from intarsia.files.material_sets import PLANE_WORDS, name_of
from intarsia.methods import METHODS
from intarsia.plugins import HOSTS, KNOWN, install
from intarsia.request import fields_of_verb

SOURCE = HOSTS / "gimp" / "intarsia-textures"


@pytest.fixture
def plugin(monkeypatch: pytest.MonkeyPatch) -> Iterator[SimpleNamespace]:
    """Its modules, and a GIMP that takes everything."""
    monkeypatch.syspath_prepend(SOURCE)
    for name in ("gi", "gi.repository"):
        monkeypatch.setitem(sys.modules, name, MagicMock())
    for name in ("pictures", "procedures"):
        monkeypatch.delitem(sys.modules, name, raising=False)  # tests have some of these names, too
    pictures, procedures = (importlib.import_module(name) for name in ("pictures", "procedures"))
    yield SimpleNamespace(pictures=pictures, procedures=procedures, entries=procedures.PROCEDURES)
    for name in ("pictures", "procedures"):
        del sys.modules[name]


def layer(name: str, place: tuple[int, int, int, int] = (0, 0, 9, 9)) -> Any:
    x, y, width, height = place
    made = MagicMock()
    made.get_name.return_value, made.get_offsets.return_value = name, (True, x, y)
    made.get_width.return_value, made.get_height.return_value = width, height
    return made


class TestMaps:
    def test_endings_are_those_of_files(self, plugin: SimpleNamespace) -> None:
        assert {name: words for name, words in PLANE_WORDS.items() if name != "mask"} == plugin.pictures.WORDS

    @pytest.mark.parametrize(
        ("name", "what"),
        [
            ("wall_normal", "normal"), ("Wall Normal #2", "normal"), ("wall-nor_dx.png", "normal"),
            ("wall roughness copy", "roughness"), ("wall_height copy #3", "height"), ("wall_2k_ao_1024x1024.jpg", "ao"),
            ("wall_normal_2k", "normal"), ("Background", "albedo"), ("old metal", "metallic"), ("", "albedo"),
            ("abnormal", "albedo"), ("ambient occlusion", "ao"),
        ],
    )  # fmt: skip
    def test_a_layer_is_known_by_its_name(self, plugin: SimpleNamespace, name: str, what: str) -> None:
        found, word = plugin.pictures.map_of(name)
        assert found == what
        assert name_of(f"layer1_{word}.tif") == ("layer1", what)

    def test_the_picture_comes_first(self, plugin: SimpleNamespace) -> None:
        layers = [layer("wall_height"), layer("wall_normal"), layer("wall")]
        assert [what for what, _, _ in plugin.pictures.maps_of(layers)] == ["albedo", "normal", "height"]

    @pytest.mark.parametrize(
        ("layers", "line"),
        [
            ([layer("wall"), layer("wall 2")], "wall and wall 2 both are the albedo"),
            ([layer("a_normal"), layer("a_height")], "Select the picture, too"),
            ([layer("wall"), layer("wall_normal", (1, 0, 9, 9))], "must have one size"),
        ],
    )
    def test_what_is_no_material_is_refused(self, plugin: SimpleNamespace, layers: list[Any], line: str) -> None:
        with pytest.raises(plugin.pictures.Refused, match=line):
            plugin.pictures.maps_of(layers)


class TestFiles:
    @pytest.mark.parametrize("kind", ["u8", "u16", "float"])
    @pytest.mark.parametrize("channels", [1, 2, 3, 4])
    def test_numbers_arrive_as_they_are(
        self, plugin: SimpleNamespace, tmp_path: Path, kind: str, channels: int
    ) -> None:
        dtype = {"u8": np.uint8, "u16": np.uint16, "float": np.float32}[kind]
        pixels = np.random.default_rng(1).integers(0, 256, (5, 7, channels)).astype(dtype)
        alpha = channels in (2, 4)
        path = tmp_path / "layer1.tif"
        plugin.pictures.write_tiff(path, (7, 5), kind, channels, alpha, pixels.tobytes())
        plane = files.read_plane(str(path))
        assert plane.pixels.dtype == dtype
        assert plane.alpha == alpha
        assert plane.samples.shape == pixels.shape
        assert (plane.samples == pixels).all()

    def test_what_is_selected_at_all_is_white(self, plugin: SimpleNamespace, tmp_path: Path) -> None:
        plugin.pictures.save_mask(bytes([0, 1, 128, 255]), (2, 2), tmp_path / "hole1.tif")
        assert files.read_plane(str(tmp_path / "hole1.tif")).pixels.ravel().tolist() == [0, 255, 255, 255]


class TestPlaces:
    def test_around_stays_in_the_layer(self, plugin: SimpleNamespace) -> None:
        around = plugin.procedures.around
        assert around((10, 20, 5, 5), 3, (0, 0, 100, 24)) == (7, 17, 11, 7)
        assert around((10, 20, 5, 5), 0, (0, 0, 100, 24)) == (0, 0, 100, 24)

    @pytest.mark.parametrize(("take", "axis"), [("sides", 0), ("above-below", 1)])
    @pytest.mark.parametrize(("bounds", "first", "last"), [
        ((130, 150, 40, 90), (30, 50), (69, 139)),  # as wide as the selection, and at least 64 px
        ((100, 100, 10, 10), (0, 0), (36, 36)),  # less at the border
    ])  # fmt: skip
    def test_bands_beside_the_selection(
        self, plugin: SimpleNamespace, take: str, axis: int, bounds: Any, first: Any, last: Any
    ) -> None:
        bits = plugin.procedures.beside(bounds, (100, 100, 200, 190), take)
        mask = np.frombuffer(bits, np.uint8).reshape(190, 200) > 0
        lines = mask.any(axis=1 - axis)
        assert (mask == (lines[:, None] if axis == 0 else lines[None, :])).all()
        found = np.flatnonzero(lines)
        at = 1 - axis
        wide = max(bounds[2 + at], 64)
        start = bounds[at] - 100 - (wide - bounds[2 + at]) // 2
        assert (found[0], found[-1]) == (max(start, 0), start + wide - 1)
        assert bounds[at] - 100 >= found[0]
        assert bounds[at] - 100 + bounds[2 + at] - 1 <= found[-1]


class TestFields:
    def test_at_most_five_with_words_of_their_own(self, plugin: SimpleNamespace) -> None:
        for wanted in plugin.entries.values():
            fields = [field for _, part in wanted.sections for field in part]
            assert len(fields) <= 5
            assert all(field.label and field.tip.endswith((".", "side", "image")) for field in fields)

    def test_no_letter_stands_twice(self, plugin: SimpleNamespace) -> None:
        for name, wanted in plugin.entries.items():
            labels = [field.label for _, part in wanted.sections for field in part]
            letters = [label[label.index("_") + 1].lower() for label in labels]
            assert len({*letters, *"lsrco"}) == len(letters) + 5, name  # those of GIMP's buttons

    def test_values_are_those_of_the_command(self, plugin: SimpleNamespace) -> None:
        assert set(plugin.procedures.METHOD.values) - {"auto"} <= set(METHODS)
        for verb, flag, field in (("grow", "--wrap", "WRAP"), ("tile", "--axes", "DIRECTIONS")):
            known = next(f for f in fields_of_verb(verb) if flag in f.flags)
            values = getattr(plugin.procedures, field)
            assert set(getattr(values, "values", None) if field == "WRAP" else values) <= set(known.kind.choices)


class TestInstalled:
    def test_gimp_can_start_it(self, tmp_path: Path) -> None:
        (placed,) = install("gimp", str(tmp_path))
        script = placed / f"{KNOWN['gimp'].name}.py"
        assert os.access(script, os.X_OK)
        assert script.read_text().startswith("#!/usr/bin/env python3\n")
        assert {p.name for p in placed.iterdir()} == {
            "calling.py", "finding.py", "installed.json", "intarsia-textures.py", "pictures.py", "procedures.py",
        }  # fmt: skip

    def test_the_bit_is_set_even_where_an_installer_lost_it(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        import shutil

        copied = tmp_path / "hosts"
        shutil.copytree(HOSTS, copied)
        for path in copied.rglob("*.py"):
            path.chmod(0o644)
        monkeypatch.setattr("intarsia.plugins.HOSTS", copied)
        (tmp_path / "to").mkdir()
        (placed,) = install("gimp", str(tmp_path / "to"))
        assert os.access(placed / "intarsia-textures.py", os.X_OK)
