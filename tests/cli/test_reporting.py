"""``--report``: pages beside pictures, one for each output."""

from __future__ import annotations

import json
import re
import shlex
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from cli.commands import run
from judging.naive_windows import blobs

import intarsia as ia

STONES = (blobs(72, 72, 1) // 4).astype(np.uint8)
SMALL = ("--size", "80", "--method", "image-quilting", "--patch", "24")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    ia.write("stones.png", ia.Plane(STONES))
    ia.write("moss.png", ia.Plane(STONES[::-1]))
    hole = np.zeros((72, 72), np.uint8)
    hole[30:40, 30:40] = 255
    ia.write("hole.png", ia.Plane(hole))
    ia.write("labels.png", ia.Plane((np.arange(72 * 72).reshape(72, 72) % 72 < 36).astype(np.uint8) * 255))
    return tmp_path


def there() -> set[str]:
    """What was written; nothing half done is left."""
    return {p.name for p in Path().iterdir()} - {"stones.png", "moss.png", "hole.png", "labels.png"}


LINES = {
    "grow": ("grow", "stones.png", *SMALL),
    "extend": ("extend", "stones.png", "--right", "20", "--patch", "16"),
    "heal": ("heal", "stones.png", "--mask", "hole.png", "--patch", "8"),
    "paint": ("paint", "stones.png", "--labels", "labels.png", "--target", "labels.png", "--patch", "16"),
}


@pytest.mark.parametrize("command", LINES)
def test_what_makes_a_picture_makes_a_report(command: str) -> None:
    run(*LINES[command], "-o", "out.png", "--report", "out.html")
    page = Path("out.html").read_text("utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert there() == {"out.png", "out.html"}
    again = shlex.split(unescape(re.findall(r"<pre>(intarsia .*?)</pre>", page, re.DOTALL)[0]))
    before = ia.read("out.png").base.pixels
    run(*again[1:], "--force")
    assert np.array_equal(ia.read("out.png").base.pixels, before)


def test_a_replay_has_a_report_too() -> None:
    run(*LINES["grow"], "-o", "out.png")
    run("replay", "out.png", "-o", "again.png", "--exemplar", "stones.png", "--report", "again.html")
    assert "again.png" in Path("again.html").read_text("utf-8")
    assert "intarsia grow stones.png" in Path("again.html").read_text("utf-8")
    assert there() == {"out.png", "again.png", "again.html"}


def test_a_report_changes_nothing_and_a_dry_run_names_it() -> None:
    plan = run(*LINES["grow"], "-o", "out.png", "--report", "out.html", "--dry-run", "--json")
    assert "out.html" in [f["path"] for f in json.loads(plan.stdout)["files"]]
    assert there() == set()
    run(*LINES["grow"], "-o", "plain.png")
    run(*LINES["grow"], "-o", "out.png", "--report", "out.html")
    assert Path("plain.png").read_bytes() == Path("out.png").read_bytes()
    assert there() == {"plain.png", "out.png", "out.html"}


def test_each_output_has_a_page() -> None:
    run(*LINES["grow"], "-o", "{seed}.png", "--seeds", "1..2", "--report", "{seed}.html")
    assert there() == {"1.png", "2.png", "1.html", "2.html"}
    both = ("grow", "stones.png", "moss.png", *SMALL[2:], "--size", "60")
    run(*both, "-o", "b_{stem}.png", "--report", "b_{stem}.html")
    assert {"b_stones.html", "b_moss.html"} <= there()


REFUSED = {
    "--report out.pdf": "end its name in .html",
    "--report -": "end its name in .html",
    "--report out.png": "end its name in .html",
    "--seeds 1..2 -o {seed}.png --report all.html": "put {stem} or {seed}",
    "--seeds 1..2 -o {seed}.png --report {stem}.html": "written twice",
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_work_is_refused_before_it_begins(words: str) -> None:
    given = words.split()
    out = [] if "-o" in given else ["-o", "out.png"]
    assert REFUSED[words] in run(*LINES["grow"], *out, *given, code=2).stderr
    assert there() == set()


def test_turned_pieces_are_judged_too() -> None:
    turned = ("grow", "stones.png", "--size", "64", "--method", "parallel-controllable", "--angle", "20", "-o", "t.png")
    run(*turned, "--report", "t.html")
    assert there() == {"t.png", "t.html"}


def test_score_writes_one_too() -> None:
    run(*LINES["grow"], "-o", "out.png", "--save-map", "m.npz")
    run("score", "stones.png", "out.png", "--map", "m.npz", "--report", "out.html")
    page = Path("out.html").read_text("utf-8")
    assert "The pieces" in page
    assert "Its recipe" in page
    assert "exists" in run("score", "stones.png", "out.png", "--report", "out.html", code=2).stderr
    run("score", "stones.png", "out.png", "--report", "out.html", "--force", "--gate", "total=99.9", code=4)
    assert "Falls short: total" in Path("out.html").read_text("utf-8")
    answer = run("score", "stones.png", "moss.png", "--report", "moss.png.html", "--json")
    assert json.loads(answer.stdout)["report"] == "moss.png.html"


def test_names_may_hold_anything() -> None:
    name = "<b>'&\"<script>.png"
    Path(name).write_bytes(Path("stones.png").read_bytes())
    run("grow", name, *SMALL, "-o", "{stem}_x.png", "--report", "{stem}.html")
    page = Path("<b>'&\"<script>.html").read_text("utf-8")
    assert "<script" not in page
    assert "<b>'" not in page


def test_each_material_of_a_folder_has_a_page() -> None:
    for name, picture in {"a": STONES, "set/moss_albedo": STONES[::-1]}.items():
        Path("in", name).parent.mkdir(parents=True, exist_ok=True)
        ia.write(Path("in", name + ".png"), ia.Plane(picture))
    ia.write("in/set/moss_height.png", ia.Plane(STONES[..., 0]))
    grow = ("grow", "in/", "-o", "out/", "--size", "80", "--method", "random-tiling", "--patch", "24", "--report")
    assert "put {stem} into its name" in run(*grow, "all.html", code=2).stderr
    made = json.loads(run(*grow, "{stem}.html", "--json").stdout)
    assert all(0 < one["score"]["total"] < 100 for one in made["results"])
    assert {"a.html", "moss.html"} <= there()
