"""Replay: every command's picture again, byte for byte, from its recipe and the same files; other files are refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from cli import commands
from click.testing import Result
from numpy.typing import NDArray
from search.test_guide import disc, painted, regions

import intarsia as ia
from intarsia import files
from intarsia.tasks.completion import Margins, extended
from intarsia.testing.cases import texture

RED, BLUE = (255, 0, 0), (0, 0, 255)
SMALL = "--patch 12 --overlap 4 --seed 5"


def run(line: str, code: int = 0) -> Result:
    return commands.run(f"{line} -q", code=code)


def write(name: str, pixels: NDArray[np.generic]) -> None:
    files.write(name, ia.Plane(np.ascontiguousarray(pixels)))


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    pixels = texture(48, 52, 3, 4)
    hole = np.zeros((48, 52), bool)
    hole[17:29, 20:31] = True
    for name, picture in {
        "a": pixels, "b": texture(48, 52, 3, 5), "c": texture(48, 52, 3, 6), "wide": texture(48, 60, 3, 4),
        "h": hole.astype(np.uint8) * 255, "h2": np.roll(hole, 3, 0).astype(np.uint8) * 255,
        "u": np.where(np.arange(52) < 46, 255, 0).astype(np.uint8)[None].repeat(48, 0),
        "u2": np.where(np.arange(52) < 44, 255, 0).astype(np.uint8)[None].repeat(48, 0),
        "clear": np.dstack([pixels, np.where(hole, 0, 255).astype(np.uint8)]),
        "pink": np.where(hole[:, :, None], np.array([255, 0, 255], np.uint8), pixels),
    }.items():  # fmt: skip
        write(f"{name}.png", picture)
    marks = regions(70, 60)
    files.write("e.png", painted(marks).base)
    files.write("e2.png", painted(marks[::-1]).base)
    colours = np.array([RED, BLUE], np.uint8)
    for name, picture in {
        "l": colours[marks], "l2": colours[marks[::-1]], "swapped": colours[1 - marks],
        "t": colours[disc(64)], "t2": colours[np.roll(disc(64), 1, 0)],
    }.items():  # fmt: skip
        write(f"{name}.png", picture)


MADE = {
    "grow": (f"grow a.png --size 60 {SMALL}", "-e a.png"),
    "grow with a mask": (f"grow a.png --size 60 --mask u.png {SMALL}", "-e a.png --mask u.png"),
    "grow by other rules": (
        f"grow a.png --size 60 {SMALL} --tolerance 0.3 --channel-weights 0.2,0.7,0.1 --isometries 0,1 "
        "--repeat-penalty 0 --search exact --seam gradient --feather 4 --debug", "-e a.png",
    ),
    "grow what wraps": (f"grow a.png --size 60 {SMALL} --toroidal --wrap x --feather 2 --mixing source", "-e a.png"),
    "grow a part": (f"grow a.png --size 60 {SMALL} --crop 4,2,30,32 --depth 16", "-e a.png"),
    "grow by half": ("grow a.png --size 60 --scale 0.5 --patch 8", "-e a.png"),
    "grow with alpha": (f"grow clear.png --size 60 {SMALL} --alpha channel", "-e clear.png"),
    "grow tiles": ("grow a.png --size 60 --patch 12 --method random-tiling", "-e a.png"),
    "grow avoiding": (f"grow pink.png --size 60 --avoid #ff00ff {SMALL}", "-e pink.png"),
    "extend": (f"extend a.png --left 9 --top 4 {SMALL}", "-e a.png"),
    "extend from others": (
        f"extend a.png --right 20 --from b.png --from c.png {SMALL}", "-e a.png --from b.png --from c.png",
    ),
    "extend with a mask": (f"extend a.png --right 9 --mask u.png {SMALL}", "-e a.png --mask u.png"),
    "extend wrapping": (f"extend a.png --bottom 12 --wrap x {SMALL}", "-e a.png"),
    "heal": ("heal a.png --mask h.png --seed 3", "-e a.png --mask h.png"),
    "heal a larger hole": ("heal a.png --mask h.png --grow 2 --patch 14", "-e a.png --mask h.png"),
    "heal the edge again": ("heal a.png --mask h.png --edge 2 --patch 14", "-e a.png --mask h.png"),
    "heal from another": ("heal a.png --mask h.png --from b.png --patch 14", "-e a.png --from b.png --mask h.png"),
    "heal with usable": ("heal a.png --mask h.png --usable u.png --patch 14", "-e a.png --mask h.png --usable u.png"),
    "heal avoiding": ("heal pink.png --mask h.png --avoid #ff00ff --patch 14", "-e pink.png --mask h.png"),
    "heal alpha": ("heal clear.png --mask alpha --alpha mask --patch 14", "-e clear.png"),
    "heal alpha as a channel": ("heal clear.png --mask alpha --patch 14 --grow 1", "-e clear.png"),
    "heal by sampling": ("heal a.png --mask h.png --method patch-sampling --patch 8", "-e a.png --mask h.png"),
    "heal across the border": ("heal a.png --mask h.png --wrap both --toroidal --patch 14", "-e a.png --mask h.png"),
    "tile": ("tile a.png --seed 3", "-e a.png"),
    "tile a part": ("tile a.png --axes y --size 44x40 --band 14 --patch 10", "-e a.png"),
    "tile from another": ("tile a.png --from b.png --patch 12", "-e a.png --from b.png"),
    "tile with a mask": ("tile a.png --mask u.png --patch 12", "-e a.png --mask u.png"),
    "tile and repair": ("tile a.png --axes x --repair 2 --method image-quilting", "-e a.png"),
    "paint": (f"paint e.png -l l.png -t t.png {SMALL}", "-e e.png -l l.png -t t.png"),
    "paint by sampling": (
        "paint e.png -l l.png -t t.png --method patch-sampling --patch 8 --weight 1.5 --reach 4",
        "-e e.png -l l.png -t t.png",
    ),
    "paint with two": (
        f"paint e.png e2.png --several -l l.png -l l2.png -t t.png {SMALL}",
        "-e e.png -e e2.png --several -l l.png -l l2.png -t t.png",
    ),
    "paint a part": (f"paint e.png -l l.png -t t.png --crop 4,6,50,60 {SMALL}", "-e e.png -l l.png -t t.png"),
}  # fmt: skip


@pytest.mark.parametrize("name", list(MADE))
def test_what_was_made_is_made_again_byte_for_byte(name: str) -> None:
    made, again = MADE[name]
    run(f"{made} -o out.png")
    run(f"replay out.png -o again.png {again}")
    assert Path("again.png").read_bytes() == Path("out.png").read_bytes()
    text = json.dumps(files.read_recipe("out.png"))
    assert ".png" not in text
    assert "/" not in text.replace("1/", "")


OTHERS = {
    "grow": {"-e b.png": "b is another exemplar"},
    "grow with a mask": {"-e a.png --mask u2.png": "another exemplar", "-e a.png": "another exemplar"},
    "extend": {"-e b.png": "b is another exemplar", "-e wide.png": "wide is another exemplar"},
    "extend from others": {
        "-e a.png --from c.png --from b.png": "c is another exemplar",
        "-e a.png --from b.png": "the recipe has 3 exemplars, 2 are given",
    },
    "heal": {
        "-e a.png --mask h2.png": "h2.png marks another hole",
        "-e b.png --mask h.png": "b is another exemplar",
        "-e wide.png --mask h.png": "the mask h.png is 52x48 px, wide 60x48",
        "-e a.png --mask gone.png": "gone.png does not exist",
        "-e a.png --mask h.png --usable u.png": "a is another exemplar",
    },
    "tile": {"-e b.png": "b is another exemplar", "-e wide.png": "wide is another exemplar"},
    "heal a larger hole": {"-e a.png --mask h2.png": "h2.png marks another hole"},
    "heal alpha": {"-e b.png": "b.png has no alpha"},
    "heal alpha as a channel": {"-e b.png": "has no alpha"},
    "paint": {
        "-e e.png -l l.png -t t2.png": "t2.png holds other labels",
        "-e e.png -l l2.png -t t.png": "l2.png holds other labels",
        "-e e.png -l swapped.png -t t.png": "swapped.png holds other labels",
        "-e e2.png -l l.png -t t.png": "e2 is another exemplar",
    },
    "paint with two": {"-e e.png -e e2.png --several -l l.png -l l.png -t t.png": "l.png holds other labels"},
}
LEFT_OUT = {
    "heal": {"-e a.png": "made with --mask FILE", "-e a.png --mask h.png --from b.png": "made without --from"},
    "heal alpha": {"-e clear.png --mask h.png": "made without --mask"},
    "extend from others": {"-e a.png": "made with --from FILE"},
    "paint": {"-e e.png -t t.png": "made with --labels FILE", "-e e.png -l l.png": "made with --target FILE"},
    "grow": {"-e a.png -l l.png": "made without --labels", "-e a.png --start m.npz": "made without --start"},
}


@pytest.mark.parametrize(("refused", "code"), [(OTHERS, 3), (LEFT_OUT, 2)], ids=["other files", "files left out"])
def test_other_files_are_refused_by_name_in_one_line(refused: dict[str, dict[str, str]], code: int) -> None:
    for name, cases in refused.items():
        run(f"{MADE[name][0]} -o out.png --force")
        for given, message in cases.items():
            told = run(f"replay out.png -o again.png {given}", code).stderr
            assert message in told, given
            assert len(told.splitlines()) == 1
            assert not Path("again.png").exists()


def test_pictures_of_the_library_are_replayed_too() -> None:
    hole = files.read_plane("h.png").pixels > 0
    healed = ia.heal("a.png", hole, ia.ImageQuilting(patch=14), grow=1, seed=2)
    wider = ia.extend("a.png", Margins(right=11), ia.ImageQuilting(patch=12), sources=["b.png"])
    for made, given in ((healed, "--mask h.png"), (wider, "--from b.png")):
        files.write("made.png", made.render(), recipe=made.recipe_text, force=True)
        run(f"replay made.png -o again.png --force -e a.png {given}")
        assert Path("again.png").read_bytes() == Path("made.png").read_bytes()


@pytest.mark.parametrize("guided", [False, True])
def test_a_start_map_is_named_again(guided: bool) -> None:
    """A map with a filled corner, continued plainly and under labels: the map is checked by its hash."""
    e = ia.read("e.png")
    start = extended([e.source], 0, Margins(right=24, bottom=18))
    start.save("start.npz")
    extended([e.source], 0, Margins(left=24, bottom=18)).save("other.npz")
    method, guide, given = ia.ImageQuilting(patch=14, overlap=4), None, "-e e.png"
    if guided:
        marks = np.pad(regions(70, 60), ((0, 18), (0, 24)), mode="edge")
        write("target.png", marks * 255)
        write("labels.png", regions(70, 60) * 255)
        label = {"meta": {"labels": ("#000000", "#ffffff")}}
        planes = [ia.Plane(m.astype(np.uint8), ia.Kind.LABEL, **label) for m in (regions(70, 60), marks)]
        guide, given = ia.Guide(*planes), f"{given} -l labels.png -t target.png"
    made = ia.synthesize(e, method=method, start=start, guide=guide, seed=6)
    files.write("made.png", made.render(), recipe=made.recipe_text)
    run(f"replay made.png -o again.png {given} --start start.npz")
    assert Path("again.png").read_bytes() == Path("made.png").read_bytes()
    told = run(f"replay made.png -o other.png {given} --start other.npz", 3).stderr
    assert "other.npz is another map" in told
    assert "made with --start FILE" in run(f"replay made.png -o other.png {given}", 2).stderr


def test_all_that_is_missing_is_told_of_at_once() -> None:
    run("heal a.png --mask h.png --patch 14 --from b.png -o healed.png")
    run(f"paint e.png -l l.png -t t.png {SMALL} -o painted.png")
    for name, asked in (("healed", "--exemplar FILE, --mask FILE, --from FILE:"),
                        ("painted", "--exemplar FILE, --labels FILE, --target FILE:")):  # fmt: skip
        told = run(f"replay {name}.png -o again.png", 2).stderr
        assert f"{name}.png was made with {asked}" in told
        assert len(told.splitlines()) == 1


def test_a_set_and_the_picture_of_a_parameter_are_given_again() -> None:
    write("ramp.png", np.tile(np.arange(60, dtype=np.uint8), (60, 1)))
    method = "-m parallel-controllable --jitter-output"
    run(f"grow a.png --map height=b.png --size 60 {method} ramp.png -o out.png")
    assert "name it with --picture jitter_output=FILE" in run("replay out.png -o again.png -e a.png", 2).stderr
    run("replay out.png -o again.png -e a.png --map height=b.png --picture jitter_output=ramp.png")
    for end in ("", "_height"):
        assert Path(f"again{end}.png").read_bytes() == Path(f"out{end}.png").read_bytes()
