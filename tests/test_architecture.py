"""The page on how the house is built is true: its drawing, its rooms, and the way of one pixel."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path
from types import CodeType, FrameType

import numpy as np
import pytest
from click.testing import CliRunner
from house import FILES, FLOOR, ROOT, files_in, is_package, links, name_of, own, room_of, told, tree
from regular.test_wall import exemplar_of
from test_docs import load

import intarsia as ia
from intarsia.cli import cli

HOME = Path(__file__).resolve().parent.parent
PAGE = (HOME / "docs" / "architecture.md").read_text(encoding="utf-8")
DRAWING = load(HOME / "docs" / "make_architecture.py")

Step = tuple[str, str]
"""A file of the package, and the name of a function or method in it."""


def test_the_drawing_is_made_from_the_imports() -> None:
    """`make tables` makes it."""
    drawn = DRAWING.TARGET.read_text(encoding="utf-8")
    assert drawn == DRAWING.drawing()
    for room in FLOOR:
        if is_package(room):
            assert f">{room}</text><text" in drawn
            assert f">{len(files_in(room))} files</text>" in drawn
        else:
            assert f">{room}.py</text>" in drawn
    assert drawn.count('class="line"') == sum(map(len, links().values()))


def test_following_the_lines_leads_to_all_that_is_imported() -> None:
    """And nowhere else; no line is drawn twice."""
    lines = links()
    for room in FLOOR:
        imported = {room_of(o) for m in files_in(room) for o in own(FILES[m])} - {room}
        reached, todo = set[str](), [room]
        while todo:
            new = lines[todo.pop()] - reached
            reached |= new
            todo += new
        assert lines[room] <= imported <= reached, room


def test_every_room_is_told_of_in_its_own_words() -> None:
    table = PAGE.partition("<!-- rooms -->")[2].partition("<!-- end -->")[0]
    for room in FLOOR:
        place = room.replace(".", "/") + ("" if is_package(room) else ".py")
        assert f"| [`{place}`](../src/intarsia/{place}) | {told(room).replace('``', '`')} | " in table


def steps(heading: str) -> list[Step]:
    """The numbered lines below a heading: file and function."""
    part = re.split(r"^#+ ", PAGE.partition(f"{heading}\n")[2], maxsplit=1, flags=re.MULTILINE)[0]
    found: list[Step] = re.findall(r"^\d+\. `([\w/]+\.py)` `([\w.]+)`: ", part, re.MULTILINE)
    assert len(found) == len(re.findall(r"^\d+\. ", part, re.MULTILINE)) > 0
    return found


def defined(path: Path) -> set[str]:
    """The functions and methods of a file."""
    body = tree(path).body
    inner = [(c.name, f) for c in body if isinstance(c, ast.ClassDef) for f in c.body if isinstance(f, ast.FunctionDef)]
    return {f.name for f in body if isinstance(f, ast.FunctionDef)} | {f"{c}.{f.name}" for c, f in inner}


def test_every_file_that_is_named_is_there() -> None:
    text = re.sub(r"`(my_method\.py|wall\.png)`", "", PAGE)
    for place in re.findall(r"`((?:[\w-]+/)*[\w-]+\.(?:py|md))`", text):
        assert (ROOT / place).is_file() or (HOME / place).is_file() or "my-method" in place, place
    for place, name in re.findall(r"`([\w/]+\.py)` `([\w.]+)`", text):
        assert name in defined(ROOT / place), (place, name)
    for name, place in re.findall(r"`(\w+)`(?: and `\w+`)? of\s+`([\w/]+\.py)`", text):
        assert re.search(rf"^(def|class) {name}\b|^{name}\b", (HOME / place if place[:5] == "tests" else ROOT / place)
                         .read_text(encoding="utf-8"), re.MULTILINE), (place, name)  # fmt: skip


def called(*words: str) -> list[Step]:
    """The functions of the package that a command calls, in the order of their first calls."""
    found: dict[CodeType, None] = {}

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            found.setdefault(frame.f_code)

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        done = CliRunner().invoke(cli, words, prog_name="intarsia")
    finally:
        sys.setprofile(before)
    assert done.exit_code == 0, done.output
    paths = [(Path(code.co_filename), code.co_qualname) for code in found]
    return [(path.relative_to(ROOT).as_posix(), name) for path, name in paths if path.is_relative_to(ROOT)]


def grown(folder: Path, *words: str) -> list[Step]:
    """What is called by ``intarsia grow brick.png -o wall.png``; with one thread, as others are not looked at.

    The second time, as compiling kernels calls very much.
    """
    request = "grow", str(folder / "brick.png"), "--threads", "1", *words
    first = CliRunner().invoke(cli, [*request, "-o", str(folder / "first.png")], prog_name="intarsia")
    assert first.exit_code == 0, first.output
    return called(*request, "-o", str(folder / "wall.png"))


def test_a_pixel_goes_this_way(tmp_path: Path) -> None:
    ia.write(tmp_path / "brick.png", np.asarray(ia.read("sample:pebbles").base.pixels)[:160, :160])
    ways = steps("## The way of one pixel")
    assert len(ways) <= 20  # who needs more stations to tell the way has a house that is too large
    made = grown(tmp_path)
    assert [step for step in made if step in ways] == ways


def test_with_image_quilting_it_goes_this_way(tmp_path: Path) -> None:
    ia.write(tmp_path / "brick.png", np.asarray(ia.read("sample:stones").base.pixels)[:160, :160])
    ways = steps("### With image quilting")
    made = grown(tmp_path, "--method", "image-quilting")
    assert [step for step in made if step in ways] == ways
    usual = steps("## The way of one pixel")
    left_out = [usual[n - 1] for n in (5, 6, 9, 11, 13, 14, 15)]
    assert not set(left_out) & set(made)
    rest = [step for step in usual if step not in left_out]
    assert [step for step in made if step in rest] == rest


MOST_MODULES, MOST_ENTERED, MOST_ROOMS = 60, 60, 16
"""What a picture by image quilting may import, and the files and rooms that it may enter: a house that one can hold."""


def test_a_picture_meets_a_small_part_of_the_house(tmp_path: Path) -> None:
    ia.write(tmp_path / "brick.png", np.asarray(ia.read("sample:stones").base.pixels)[:160, :160])
    steps = grown(tmp_path, "--method", "image-quilting")
    entered = {place for place, name in steps if name != "<module>"} | {"__main__.py"}  # which `called` does without
    assert len(entered) <= MOST_ENTERED
    assert len({room_of(name_of(ROOT / place)) for place in entered}) <= MOST_ROOMS
    script = """
import sys
from intarsia.__main__ import main
try:
    main()
finally:
    print(sum(name.partition(".")[0] == "intarsia" for name in sys.modules), file=sys.stderr)
"""
    words = ["grow", tmp_path / "brick.png", "-m", "image-quilting", "-o", tmp_path / "alone.png", "--quiet"]
    done = subprocess.run([sys.executable, "-c", script, *words], capture_output=True, text=True, check=True)
    assert int(done.stderr.split()[-1]) <= MOST_MODULES


def test_bricks_go_this_way(tmp_path: Path) -> None:
    pixels, _ = exemplar_of((25, (40, 55, 70), 4))
    ia.write(tmp_path / "brick.png", pixels)
    ways = steps("### With courses of bricks")
    made = grown(tmp_path)
    assert [step for step in made if step in ways] == ways


@pytest.mark.parametrize("line", re.findall(r"pytest (tests/.*)", PAGE))
def test_the_tests_that_are_named_are_there(line: str) -> None:
    for name in re.findall(r"tests/\w+\.py", line):
        assert (HOME / name).is_file()
