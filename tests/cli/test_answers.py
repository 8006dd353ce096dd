"""grow, extend, heal, paint, tile and weave answer alike: options, JSON, explanation, a plan."""

from __future__ import annotations

import json
import os
import shlex
from pathlib import Path

import click
import numpy as np
import pytest
from cli.commands import run, told

import intarsia as ia
from intarsia import files
from intarsia.cli import cli
from intarsia.cli.verbs import parameters_of
from intarsia.model.image import Transfer
from intarsia.testing import texture

LINES = {
    "grow": "grow a.png --size 60x50",
    "extend": "extend a.png --right 12",
    "heal": "heal a.png --mask hole.png",
    "paint": "paint a.png --labels l.png --target t.png",
    "tile": "tile a.png",
    "weave": "weave a.png --size 60x50",
}
"""What is asked of each command, but for a method and a place for the output."""

DONE = {
    "grow": "a_grown.png", "extend": "a_extended.png", "heal": "a_healed.png", "paint": "a_painted.png",
    "tile": "a_tiled.png", "weave": "a_woven.tif",
}  # fmt: skip
"""Where it goes if nothing is said."""

SHARED = {"explain", "seed", "out", "force", "dry_run", "threads", "as_json", "progress", "quiet"}
PICTURES = SHARED | {"many", "sheet", "depth", "save_map"}
"""The options that every command has; and those that all have which write pictures that fit into memory."""

RESULT = {"files", "size", "seed", "wrap", "method", "parameters", "blend", "exemplars", "auto",
          "timings", "warnings"}  # fmt: skip
PLAN = RESULT - {"timings"} | {"dry_run", "memory_mib"}
OVERLAPS = ({"energy", "overlaps"}, set[str]())
OWN = {"grow": OVERLAPS, "paint": OVERLAPS, "weave": ({"origin"}, {"origin", "cells", "pixels_bytes", "seconds"})}
"""What the JSON of a result and of a plan hold, and what one command adds to each; the others tell an energy."""


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    y, x = np.mgrid[:40, :48]
    files.write("a.png", ia.Plane(texture(40, 48, 3, 4)))
    files.write("b.png", ia.Plane(texture(40, 48, 3, 5)))
    files.write("hole.png", ia.Plane(((abs(x - 20) < 4) & (abs(y - 18) < 4)).astype(np.uint8) * 255))
    files.write("l.png", ia.Plane(np.where(x < 24, 0, 255).astype(np.uint8)))
    files.write("t.png", ia.Plane(np.where(y < 20, 0, 255).astype(np.uint8)))


def parameters(name: str) -> dict[str, click.Parameter]:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    return {str(p.name): p for p in command.params or parameters_of(name)}


@pytest.mark.parametrize("name", LINES)
def test_every_command_has_the_options_that_all_have(name: str) -> None:
    mine, others = parameters(name), parameters("grow")
    for field in PICTURES if name != "weave" else SHARED:
        assert field in mine, field
        assert mine[field].opts == others[field].opts
        assert mine[field].required is False


@pytest.mark.parametrize("name", LINES)
def test_json_holds_the_same_of_every_result_and_of_every_plan(name: str) -> None:
    result, plan = OWN.get(name, ({"energy"}, set()))
    line = f"{LINES[name]} -o {DONE[name]}"
    planned = told(f"{line} --dry-run")
    assert set(planned) == PLAN | plan
    assert not Path(DONE[name]).exists()
    made = told(line)
    assert set(made) == RESULT | result
    assert "total" in made["timings"]
    for key in RESULT & PLAN - {"parameters", "auto"}:  # a patch for holes is found by trying
        assert made[key] == planned[key], key
    assert made["files"] == [{"path": DONE[name], "holds": "albedo"}]
    assert set(made["auto"]) == set(planned["auto"]) == {"rule", "why", "command"}


def explained(said: str) -> list[str]:
    """The words that stand before the lines of an explanation, but for those that tell of warnings."""
    heads = [line[:13].strip() for line in said.splitlines() if line[12:13] == " " and line[0] != " "]
    return [head for head in heads if head.isalpha() and head != "warning"]


@pytest.mark.parametrize("name", LINES)
def test_an_explanation_has_the_same_lines_everywhere(name: str) -> None:
    """With --dry-run and without, for people and in JSON; not where the method was named, nor with --quiet."""
    wanted = explained(run(f"{LINES['grow']} -o {DONE['grow']} --dry-run --explain").stderr)
    assert wanted[0] == "lattice"
    assert wanted[-1] == "command"
    for more in (" --dry-run", ""):
        done = run(f"{LINES[name]} -o {DONE[name]} --explain --json{more}")
        lines = done.stderr.splitlines()
        assert explained(done.stderr) == wanted
        auto = json.loads(done.stdout)["auto"]
        assert set(auto) == {"rule", "why", "command", "measurements"}
        assert f"{'rule':13}{auto['rule']}" in lines
        assert f"{'command':13}{auto['command']}" in lines
    method = "repeat" if name in ("grow", "weave") else "image-quilting"
    refused = run(f"{LINES[name]} --explain --method {method} --force", code=2).stderr
    assert refused == "intarsia: --explain belongs to --method auto; name that, or drop it.\n"
    assert run(f"{LINES[name]} --explain --quiet --dry-run -o other.tif").stderr == ""


MORE = {
    "grow": " --even-tone 3 --wrap x --feather 2",
    "extend": " --top 3 --from b.png --seed 4",
    "heal": " --grow 1 --edge 1 --usable m.png --tolerance 0.1",
    "paint": " --weight 1.5 --reach 2 --several b.png --labels t.png --wrap y",
    "tile": " --axes x --band 12 --size 40x36 --mask m.png --repair 1 --tolerance 0.1",
    "weave": " --origin -7,1000 --seed 4 --even-tone 2",
}


@pytest.mark.parametrize("more", [False, True])
@pytest.mark.parametrize("name", LINES)
def test_the_command_that_is_told_makes_the_picture_without_auto(name: str, more: bool) -> None:
    files.write("m.png", ia.Plane(np.where(np.mgrid[:40, :48][0] < 2, 0, 255).astype(np.uint8)))
    made = told(LINES[name] + (MORE[name] if more else ""))
    path = made["files"][0]["path"]
    first = files.read_plane(path).pixels
    os.unlink(path)
    words = shlex.split(made["auto"]["command"])
    assert words[:2] == ["intarsia", name]
    assert words[words.index("--method") + 1] == made["method"]
    run(shlex.join([*words[1:], "-q"]))
    assert np.array_equal(files.read_plane(path).pixels, first)


@pytest.mark.parametrize("name", LINES)
def test_progress_and_quiet(name: str) -> None:
    lines = run(f"{LINES[name]} --progress json -q -o out.tif").stderr.splitlines()
    *facts, last = [json.loads(line) for line in lines]
    assert all(set(f) == {"stage", "done", "total", "fraction", "remaining"} for f in facts)
    assert facts[-1]["fraction"] == 1.0
    assert set(last) == {"result"}
    again = run(f"{LINES[name]} -q -o quiet.tif")
    assert again.stdout + again.stderr == ""


@pytest.mark.parametrize("name", [n for n in LINES if n != "weave"])
def test_batches_of_seeds_and_their_sheet(name: str) -> None:
    made = told(f"{LINES[name]} --seeds 1..2 --sheet sheet.png")
    paths = [f["path"] for r in made["results"] for f in r["files"]]
    assert paths == [f"{DONE[name][:-4]}_{seed}.png" for seed in (1, 2)]
    assert made["sheet"] == "sheet.png"
    assert all(Path(p).exists() for p in (*paths, "sheet.png"))


class TestNames:
    """Without -o a picture is named after its exemplars, in the working folder."""

    @pytest.mark.parametrize("name", LINES)
    def test_the_line_says_it_and_nothing_is_replaced_unasked(self, name: str) -> None:
        os.mkdir("elsewhere")
        os.rename("a.png", "elsewhere/a.png")
        line = LINES[name].replace("a.png", "elsewhere/a.png") + " --method repeat" * (name in ("grow", "weave"))
        said = run(line).stderr.splitlines()[-1]
        assert said.startswith(f"{DONE[name]}: ")
        assert os.listdir("elsewhere") == ["a.png"]
        assert run(line, code=2).stderr.startswith(f"intarsia: {DONE[name]} exists")
        run(f"{line} --force")

    def test_samples_and_the_standard_input(self) -> None:
        assert told("grow sample:stones --size 40 --dry-run")["files"][0]["path"] == "stones_grown.png"
        data = Path("a.png").read_bytes()
        for line, name in (
            ("grow -", "grown.png"), ("extend -", "extended.png"), ("weave - --size 40", "woven.tif"),
        ):  # fmt: skip
            done = run(f"{line} --dry-run --json", data=data)
            assert json.loads(done.stdout)["files"][0]["path"] == name

    def test_several_exemplars(self) -> None:
        for letter in "cd":
            files.write(f"{letter}.png", ia.Plane(texture(40, 48, 3, ord(letter))))
        for line, names in (
            ("grow a.png b.png", ["a_b_grown.png"]),
            ("grow a.png b.png c.png d.png", ["a_3_more_grown.png"]),
            ("extend a.png b.png", ["a_extended.png", "b_extended.png"]),
            ("heal a.png b.png --mask hole.png", ["a_healed.png", "b_healed.png"]),
            ("extend a.png --from b.png", ["a_extended.png"]),
            ("tile a.png b.png", ["a_tiled.png", "b_tiled.png"]),
        ):
            made = told(f"{line} --dry-run")
            assert [r["files"][0]["path"] for r in made.get("results", [made])] == names

    def test_sets_keep_the_formats_of_their_planes(self) -> None:
        files.write("w_albedo.tif", ia.Plane(texture(40, 48, 3, 4)))
        files.write("w_normal.jpg", ia.Plane(np.full((40, 48, 3), [128, 128, 255], np.uint8)))
        height = texture(40, 48, 1, 5).astype(np.float16) / 255
        files.write("w_height.exr", ia.Plane(height, ia.Kind.DATA, Transfer.LINEAR))
        made = told("grow w_albedo.tif w_normal.jpg w_height.exr --method repeat")
        assert {f["holds"]: f["path"] for f in made["files"]} == {
            "albedo": "w_grown.tif", "normal": "w_grown_normal.png", "height": "w_grown_height.exr"
        }  # fmt: skip
        assert all(Path(f["path"]).exists() for f in made["files"])

    @pytest.mark.parametrize(
        ("name", "options", "ending"),
        [
            ("x.jpg", "", ".png"),
            ("x.bmp", "", ".bmp"),
            ("x.bmp", "--depth 16", ".png"),
            ("x.bmp", "--size 40000x2", ".png"),  # more than a BMP holds
            ("x.TIF", "", ".tif"),
            ("x.tif", "--depth half", ".exr"),
            ("x.png", "--depth float", ".exr"),
            ("x.v2.png", "", ".png"),
            ("x.hdr", "", ".exr"),
            ("x.exr", "", ".exr"),
            ("x.pfm", "", ".pfm"),
            ("x.exr", "--depth 8", ".png"),
        ],
    )
    def test_the_format_loses_nothing_and_holds_the_result(self, name: str, options: str, ending: str) -> None:
        pixels = texture(40, 48, 3, 4)
        light = ia.Plane((pixels / 255).astype(np.float32), ia.Kind.COLOUR, Transfer.LINEAR)
        files.write(name, light if name.endswith((".hdr", ".exr", ".pfm")) else ia.Plane(pixels))
        made = told(f"grow {name} --method repeat {options} --dry-run")
        assert made["files"][0]["path"] == f"{name.rpartition('.')[0]}_grown{ending}"

    def test_an_empty_name_is_still_refused(self) -> None:
        for line in LINES.values():
            assert "-o: an empty name was given" in run(f'{line} -o ""', code=2).stderr


def test_the_line_names_the_method_that_led_to_the_end() -> None:
    """Courses that fit no canvas of 490 px are left for the next method: the line tells what the recipe tells."""
    done = run("grow sample:setts --size 490 --wrap both -o left.png")
    assert "near-regular was left" in done.stderr
    made = told("grow sample:setts --size 490 --wrap both -o left.png --force")["method"]
    assert made != "near-regular"
    assert f" px, {made}, seed 0" in done.stderr + done.stdout
