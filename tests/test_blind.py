"""Blind sheets: what is graded left and right is counted for the version that lay there, whatever the order was."""

import csv
import json

import blind
import numpy as np
import pytest
from PIL import Image


@pytest.fixture
def compared(tmp_path):
    """Eight pairs: version A is red, version B is blue."""
    for version, colour in (("A", (200, 0, 0)), ("B", (0, 0, 200))):
        folder = tmp_path / version / "1"
        folder.mkdir(parents=True)
        for number in range(8):
            Image.new("RGB", (20, 20), colour).save(folder / f"t{number}.png")
    Image.new("RGB", (10, 10), (0, 200, 0)).save(tmp_path / "green.png")
    names = {f"t{number}": str(tmp_path / "green.png") for number in range(8)}
    (tmp_path / "exemplars.json").write_text(json.dumps(names))
    return tmp_path


def reddish(path):
    """Which side of a sheet is red."""
    shown = np.asarray(Image.open(path))
    return "L" if shown[5, 10 + blind.GAP + 5, 0] > 100 else "R"


def test_photographs_stand_in_for_a_version(tmp_path):
    """The middle of what an exemplar was cut from, where that is there and larger."""
    whole = np.random.default_rng(1).integers(0, 256, (60, 70, 3)).astype(np.uint8)
    for name, pixels in (("a.png", whole[:20, :20]), ("a.ref.png", whole), ("b.png", whole[:20, :20])):
        Image.fromarray(pixels).save(tmp_path / name)
    Image.fromarray(whole[:20, :20]).save(tmp_path / "c.png")
    Image.fromarray(whole[:20, :30]).save(tmp_path / "c.ref.png")
    exemplars = [tmp_path / f"{name}.png" for name in "abc"]
    blind.grow({"B": blind.PHOTOGRAPH}, exemplars, tmp_path / "out", [1], 40, "")
    assert [p.name for p in (tmp_path / "out" / "B" / "1").iterdir()] == ["a.png"]
    made = np.asarray(Image.open(tmp_path / "out" / "B" / "1" / "a.png"))
    np.testing.assert_array_equal(made, whole[10:50, 15:55])


def test_both_orders_occur_and_verdicts_find_their_version(compared):
    assert blind.sheets(compared, seed=3) == 8
    red = {p.stem: reddish(p) for p in sorted((compared / "sheets").glob("*.png"))}
    assert set(red.values()) == {"L", "R"}
    lines = ["sheet,left,right,preferred,remarks"]
    lines += [f"{n},{'G' if side == 'L' else 'B'},{'G' if side == 'R' else 'B'},{side},seen" for n, side in red.items()]
    (compared / "grades.csv").write_text("\n".join(lines))
    told = blind.count(compared, compared / "grades.csv", compared / "verdicts.csv")
    assert told.splitlines()[0] == "A: good 8, flawed 0, broken 0; preferred 8"
    assert told.splitlines()[1] == "B: good 0, flawed 0, broken 8; preferred 0"
    with (compared / "verdicts.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {(r["A"], r["B"], r["preferred"]) for r in rows} == {("G", "B", "A")}
    assert sorted(r["texture"] for r in rows) == [f"t{n}" for n in range(8)]


def test_a_grade_that_is_none_is_refused(compared):
    blind.sheets(compared, seed=3)
    (compared / "grades.csv").write_text("0,G,X,L")
    with pytest.raises(SystemExit, match="grades G, X"):
        blind.count(compared, compared / "grades.csv", None)
