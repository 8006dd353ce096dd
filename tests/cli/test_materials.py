"""Folders of materials: each is grown by itself under its own name, whole or not at all, and none stops the others."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from cli.commands import run, told
from click.testing import CliRunner

import intarsia as ia
from intarsia import files
from intarsia.cli import Interrupted, cli
from intarsia.foundation import InputError, ParameterError
from intarsia.testing import texture

ALBEDOS = ("brick_albedo.png", "slate_col.png")


def put(path: str, side: int = 24) -> None:
    Path("in", path).parent.mkdir(parents=True, exist_ok=True)
    seen = texture(side, side + 4, seed=len(path))
    flat = np.full((side, side + 4, 3), [128, 128, 255], np.uint8)
    files.write(Path("in", path), ia.Plane(flat if "normal" in path else seen))


def tree(folder: str) -> list[str]:
    return sorted(p.relative_to(folder).as_posix() for p in Path(folder).rglob("*") if p.is_file())


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for path in (*ALBEDOS, "brick_height.png", "moss/albedo.png", "moss/normal.png", "wood/a/oak_col.png"):
        put(path)


GROW = ("grow", "in/", "-o", "out/", "--size", "40x36", "-m", "random-tiling", "--patch", "8")


class TestSets:
    """Packed maps and layers among the materials of a folder: no plane is lost, each file keeps its name."""

    def test_packed_maps_keep_their_files(self) -> None:
        Path("in/packs").mkdir()
        for path in ("wall_albedo.png", "wall_orm.png"):
            files.write(f"in/packs/{path}", ia.Plane(texture(24, 28, 3, seed=len(path))))
        told("grow", "in/packs/", *GROW[2:])
        assert tree("out") == ["wall_albedo.png", "wall_orm.png"]
        grown, own = (files.read_plane(Path(f, "wall_orm.png")) for f in ("out", "in/packs"))
        assert grown.channels == own.channels == 3

    def test_layers_are_all_written(self) -> None:
        seen = texture(24, 28, seed=2).astype(np.float32) / 255
        planes = {"albedo": ia.Plane(seen), "height": ia.Plane(seen[..., :1], ia.Kind.DATA)}
        Path("in/deep").mkdir()
        files.write("in/deep/wall.exr", planes)
        told("grow", "in/deep/", *GROW[2:])
        assert tree("out") == ["wall_albedo.exr", "wall_height.exr"]


class TestFound:
    def names(self, how: str = "auto") -> dict[str, list[str]]:
        return {m.name: [Path(os.fspath(f)).name for f in m.files] for m in files.materials("in", how)}

    def test_by_stem_or_by_folder(self) -> None:
        assert self.names() == {
            "brick": ["brick_albedo.png", "brick_height.png"],
            "slate_col": ["slate_col.png"],
            "moss": ["albedo.png", "normal.png"],
            "wood/a": ["oak_col.png"],
        }
        assert [m.place for m in files.materials("in")] == ["", "", "moss", "wood/a"]

    def test_every_picture_alone(self) -> None:
        assert list(self.names("several")) == [
            "brick_albedo", "brick_height", "slate_col", "moss/albedo", "moss/normal", "wood/a",
        ]  # fmt: skip
        with pytest.raises(ParameterError, match="auto or several"):
            files.materials("in", "set")

    def test_plain_pictures_are_a_material_each_and_what_is_hidden_or_a_link_is_none(self) -> None:
        put(".cache/x.png")
        os.symlink("..", "in/moss/loop")
        assert list(self.names()) == ["brick", "slate_col", "moss", "wood/a"]
        for name in ("plain/one.png", "plain/two.png"):
            put(name)
        assert {m.name for m in files.materials("in/plain")} == {"one", "two"}

    def test_a_folder_without_pictures_is_refused(self) -> None:
        Path("none/deep").mkdir(parents=True)
        with pytest.raises(InputError, match="no picture"):
            files.materials("none")
        assert "no picture" in run("grow", "none", "-o", "out/", code=3).stderr
        assert not Path("out").exists()


class TestGrown:
    def test_files_keep_names_and_places_and_are_those_of_single_commands(self) -> None:
        answer = told(*GROW)
        assert tree("out") == tree("in")
        assert "failed" not in answer
        assert [r["files"][0]["path"] for r in answer["results"]] == [
            "out/brick_albedo.png", "out/slate_col.png", "out/moss/albedo.png", "out/wood/a/oak_col.png",
        ]  # fmt: skip
        run("grow", "in/brick_albedo.png", "in/brick_height.png", "-o", "one.png", "-q", *GROW[4:])
        assert Path("one.png").read_bytes() == Path("out/brick_albedo.png").read_bytes()
        assert Path("one_height.png").read_bytes() == Path("out/brick_height.png").read_bytes()
        again = ("-e", "in/moss/albedo.png", "-e", "in/moss/normal.png", "-o", "two.png", "-q")
        run("replay", "out/moss/albedo.png", *again)
        assert Path("two.png").read_bytes() == Path("out/moss/albedo.png").read_bytes()

    def test_a_format_that_loses_something_becomes_png(self) -> None:
        Path("in/slate_col.png").unlink()
        put("slate_col.jpg")
        run(*GROW, "-q")
        assert "slate_col.png" in tree("out")

    def test_a_name_without_an_ending_is_a_folder_where_one_is_read(self) -> None:
        for there in (False, True):
            if there:
                Path("there").mkdir()
                assert "names no format" in run("grow", "in/slate_col.png", "-o", "there", code=2).stderr
            out = "there" if there else "out"
            run("grow", "in", "-o", out, *GROW[4:], "-q")
            assert tree(out) == tree("in")

    def test_one_file_for_unrelated_pictures_leads_to_a_folder(self) -> None:
        said = run("grow", "in/wood/a", "in", "-o", "one.png", code=3).stderr
        assert "both are the albedo of in; give one, or -o FOLDER/ to work on each, --several to mix" in said

    def test_files_beside_folders(self) -> None:
        run("grow", "in/moss", "in/slate_col.png", "sample:tiles", "-o", "out/", *GROW[4:], "-q")
        assert tree("out") == ["albedo.png", "normal.png", "slate_col.png", "tiles.png"]

    def test_seeds_name_the_folder(self) -> None:
        run("grow", "in/moss", "-o", "out/{seed}/", "--seeds", "1..2", *GROW[4:], "--sheet", "sheet.png", "-q")
        assert tree("out") == ["1/albedo.png", "1/normal.png", "2/albedo.png", "2/normal.png"]
        assert files.read_plane("sheet.png").width == 2 * 40 + 3 * 8
        assert "{seed}" in run("grow", "in/moss", "-o", "more/", "--seeds", "1..2", code=2).stderr

    def test_a_set_without_a_stem_is_called_as_its_folder(self) -> None:
        run("grow", "in", "-o", "out/{stem}/", *GROW[4:], "-q")
        assert {Path(p).parts[0] for p in tree("out")} == {"brick", "slate_col", "moss", "oak_col"}

    @pytest.mark.parametrize(
        "words", ["extend in --right 8", "heal in --mask in/hole/mask.png", "paint in -l l.png -t t.png"]
    )
    def test_so_do_the_other_commands(self, words: str) -> None:
        hole = np.zeros((24, 28), np.uint8)
        hole[8:12, 8:12] = 255
        files.write("hole.png", ia.Plane(hole))
        left = np.where(np.arange(28) < 14, 0, 255).astype(np.uint8)[None].repeat(24, axis=0)
        files.write("l.png", ia.Plane(left))
        files.write("t.png", ia.Plane(left[:, ::-1]))
        said = words.replace("in/hole/mask.png", "hole.png").split()
        run(*said, "-o", "out/", "--patch", "8", "-m", "image-quilting", "-q")
        assert tree("out") == tree("in")

    def test_a_dry_run_writes_nothing(self) -> None:
        answer = told(*GROW, "--dry-run")
        assert answer["dry_run"]
        assert len(answer["results"]) == 4
        assert not Path("out").exists()


class TestFailing:
    def spoil(self) -> None:
        data = Path("in/moss/normal.png").read_bytes()
        Path("in/moss/normal.png").write_bytes(data[: len(data) // 2])

    def test_one_is_told_in_a_line_and_the_others_go_on(self) -> None:
        self.spoil()
        lines = run(*GROW, "-q", code=3).stderr.splitlines()
        assert len(lines) == 2
        assert lines[0].startswith("intarsia: moss: in/moss/normal.png is damaged")
        assert lines[1] == "intarsia: 1 of 4 materials failed: moss"
        assert tree("out") == ["brick_albedo.png", "brick_height.png", "slate_col.png", "wood/a/oak_col.png"]

    @pytest.mark.parametrize("dry", [(), ("--dry-run",)])
    def test_json_lists_it_and_the_first_failure_is_the_exit_code(self, dry: tuple[str, ...]) -> None:
        self.spoil()
        Path("out").mkdir()
        Path("out/brick_height.png").write_bytes(b"mine")
        answer = told(*GROW, *dry, code=2)
        assert [(f["material"], f["exit_code"]) for f in answer["failed"]] == [("brick", 2), ("moss", 3)]
        assert len(answer["results"]) == 2
        assert Path("out/brick_height.png").read_bytes() == b"mine"
        assert not Path("out/brick_albedo.png").exists()

    def test_all_can_fail(self) -> None:
        run(*GROW, "-q")
        before = {p: Path("out", p).read_bytes() for p in tree("out")}
        answer = told(*GROW, "--seed", 5, code=2)
        assert answer["results"] == []
        assert len(answer["failed"]) == 4
        assert {p: Path("out", p).read_bytes() for p in tree("out")} == before
        run(*GROW, "--seed", 5, "--force", "-q")
        assert Path("out/slate_col.png").read_bytes() != before["slate_col.png"]

    def test_a_disk_that_fails_leaves_neither_files_nor_folders(self, monkeypatch: pytest.MonkeyPatch) -> None:
        write = files.write

        def failing(path: Any, plane: Any, **more: Any) -> None:
            if Path(path).name == "normal.png":
                raise OSError(28, "No space left on device", str(path))
            write(path, plane, **more)

        monkeypatch.setattr("intarsia.cli.batch.write", failing)
        said = run(*GROW, "-q", code=1).stderr
        assert "intarsia: moss: " in said
        assert not Path("out/moss").exists()
        assert "wood/a/oak_col.png" in tree("out")

    def test_progress_never_goes_back_and_ends_with_all(self) -> None:
        self.spoil()
        lines = list(map(json.loads, run(*GROW, "--progress", "json", "-q", code=3).stderr.splitlines()))
        assert lines[-1] == {"error": lines[-1]["error"], "kind": "materials", "exit_code": 3}
        steps = [line for line in lines if "stage" in line]
        fractions = [s["fraction"] for s in steps]
        assert fractions == sorted(fractions)
        assert fractions[-1] == 1
        assert steps[0]["stage"] == "check"

    def test_a_stop_ends_all(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("intarsia.cli.batch.write", Mock(side_effect=Interrupted))
        assert run(*GROW, "-q", code=130).stderr.splitlines()[-1].startswith("intarsia: stopped")
        assert not Path("out").exists()


@pytest.mark.parametrize(("words", "why"), [
    ("--map height=in/brick_height.png", "--map names a file of one material"), ("-o in/out/", "is read"),
    ("--mask in/slate_col.png", "--mask names a file of one material"), ("--set", "--set does not go with"),
    ("-o in/", "is read"), ("-o plain/deep/", "is no folder"), ("-o /", "the root of all folders"),
    ("-o /proc/self/out/", "/proc/"), ("-o out/{name}/", "{name} is unknown"), ("-", "standard input"),
    ("--sheet missing/s.png", "missing"),
])  # fmt: skip
def test_what_cannot_be_meant_is_refused_before_anything_is_read(words: str, why: str) -> None:
    Path("plain").write_bytes(b"")
    before = tree(".")
    result = CliRunner().invoke(cli, [*GROW, *words.split()], input=b"")
    assert result.exit_code in (1, 2, 3)
    assert result.stderr.count("\n") == 1
    assert why in result.stderr
    assert tree(".") == before


def test_pictures_that_are_left_out_are_named() -> None:
    put("preview.png")
    assert "left out, as other files there say which plane they are: in/preview.png" in run(*GROW).stderr
    assert "preview.png" not in tree("out")
    run("grow", "in", "-o", "all/", "--several", *GROW[4:], "-q")
    assert "preview.png" in tree("all")
