"""The same job through HTTP, command and library gives the same bytes."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from studio.browser import Desk
from studio.served import QUICK, Served, opened, pixels, png

import intarsia as ia
from intarsia import files
from intarsia.cli import cli
from intarsia.model.canvas import numbered

Files = dict[str, bytes]


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def left(height: int = 32, width: int = 36) -> np.ndarray:
    return np.where(np.mgrid[:height, :width][1] < width // 2, 0, 255).astype(np.uint8)


def hole() -> np.ndarray:
    y, x = np.mgrid[:32, :36]
    return (((abs(x - 18) < 4) & (abs(y - 16) < 4)) * 255).astype(np.uint8)


def by_command(line: str) -> None:
    done = CliRunner().invoke(cli, [*line.split(), "--quiet"])
    assert done.exit_code == 0, done.stderr


def grown_set(served: Served) -> tuple[Files, Callable[[], Any]]:
    sent = {"moss_albedo": png(pixels()), "moss_height": png(left()), "moss_normal": png(pixels(seed=3))}
    result = served.done("grow", [served.exemplar(**sent)["id"]], **QUICK, wrap="both", seed=4)
    for name, data in sent.items():
        Path(f"{name}.png").write_bytes(data)
    words = [f"{name}.png" for name in sent]
    by_command(f"grow {' '.join(words)} -o moss_grown.png -m image-quilting --patch 8 -s 48x40 --wrap both --seed 4")
    planes = {"normal": "moss_normal.png", "height": "moss_height.png"}
    exemplar, method = ia.read("moss_albedo.png", **planes), ia.ImageQuilting(patch=8)
    return served.files(result), lambda: ia.synthesize(exemplar, (40, 48), method, seed=4, wrap="both")


def painted(served: Served) -> tuple[Files, Callable[[], Any]]:
    labels, target = left() // 255, left(28, 30)[:, ::-1] // 255
    options = {"labels": [served.image(labels)], "target": served.image(target), "method": "image-quilting", "patch": 8}
    result = served.done("paint", [served.exemplar(coast=png(pixels()))["id"]], **options, seed=2)
    for name, drawn in (("coast", pixels()), ("l", labels), ("t", target)):
        Path(f"{name}.png").write_bytes(png(drawn))
    by_command("paint coast.png -l l.png -t t.png -o coast_painted.png -m image-quilting --patch 8 --seed 2")

    drawn = [(name, files.read_plane(name, "label")) for name in ("l.png", "t.png")]
    guide = ia.Guide(*numbered(drawn, print), weight=2.0)  # with the colours as names, as the command has them
    method = ia.ImageQuilting(patch=8)
    return served.files(result), lambda: ia.synthesize("coast.png", method=method, seed=2, guide=guide)


def healed(served: Served) -> tuple[Files, Callable[[], Any]]:
    exemplar = served.exemplar(wall=png(pixels()))["id"]
    result = served.done("heal", [exemplar], mask=[served.image(hole())], patch="6", method="image-quilting", seed=1)
    Path("wall.png").write_bytes(png(pixels()))
    Path("hole.png").write_bytes(png(hole()))
    by_command("heal wall.png --mask hole.png --patch 6 -m image-quilting --seed 1 -o wall_healed.png")
    method = ia.ImageQuilting(patch=6, tolerance=0)
    mask = hole() > 0
    return served.files(result), lambda: ia.heal("wall.png", mask, method, seed=1)


def tiled(served: Served) -> tuple[Files, Callable[[], Any]]:
    exemplar = served.exemplar(plank=png(pixels(48, 56)))["id"]
    result = served.done("tile", [exemplar], band=16, method="image-quilting", patch=8)
    Path("plank.png").write_bytes(png(pixels(48, 56)))
    by_command("tile plank.png --band 16 -m image-quilting --patch 8 -o plank_tiled.png")
    method = ia.ImageQuilting(patch=8, tolerance=0)
    return served.files(result), lambda: ia.tile("plank.png", method, band=16)


@pytest.mark.parametrize("case", [grown_set, painted, healed, tiled])
def test_page_command_and_library_make_the_same_bytes(
    case: Callable[[Served], tuple[Files, Callable[[], Any]]], served: Served
) -> None:
    found, library = case(served)
    pictures = {name: data for name, data in found.items() if name != "map.npz"}
    assert pictures
    for name, data in pictures.items():
        assert Path(name).read_bytes() == data, name
    made = library()
    first = min(pictures, key=len)
    files.write("library.png", made.render(), recipe=made.recipe_text)
    assert Path("library.png").read_bytes() == pictures[first]
    assert made.map.digest == ia.SourceMap.load(_written(found["map.npz"])).digest


def _written(data: bytes) -> str:
    Path("served.npz").write_bytes(data)
    return "served.npz"


def test_what_a_person_makes_on_the_page_is_what_the_library_makes(page: Desk) -> None:
    page.drop(rock=png(pixels(40, 44)))
    page.page.get_by_role("heading", name="rock").wait_for()
    page.quick()
    page.button("Grow").click()
    result = page.served.get(f"/api/results/{page.grown()}")
    Path("rock.png").write_bytes(png(pixels(40, 44)))
    made = ia.synthesize("rock.png", (80, 96), ia.ImageQuilting(), seed=page.jobs[-1]["options"].get("seed", 0))
    files.write("library.png", made.render(), recipe=made.recipe_text)
    assert Path("library.png").read_bytes() == page.served.files(result)["rock_grown.png"]
    by_command(result["command"].partition(" ")[2])
    assert Path("rock_grown.png").read_bytes() == Path("library.png").read_bytes()


def test_the_command_to_copy_makes_the_same_bytes(served: Served) -> None:
    exemplar = served.exemplar(rock=png(pixels()))["id"]
    result = served.done("grow", [exemplar], **QUICK, seed=9, crop=[2, 2, 30, 28])
    Path("rock.png").write_bytes(png(pixels()))
    name, _, line = result["command"].partition(" ")
    assert name == "intarsia"
    by_command(line)
    assert Path("rock_grown.png").read_bytes() == served.files(result)["rock_grown.png"]


@pytest.mark.parametrize(
    ("verb", "options"),
    [
        ("grow", QUICK | {"seed": 9, "wrap": "x", "patch": "10x8", "overlap": "3"}),
        ("grow", {"method": "parallel-controllable", "jitter": "0.3,0.2", "size": "40x44", "even_tone": 4}),
        ("grow", {"size": "50x40", "seed": 2}),
        ("grow", QUICK | {"crop": "1,1,30,28"}),
        ("extend", {"right": 6, "patch": "8", "method": "image-quilting"}),
    ],
    ids=["quilted", "jittered", "chosen", "cropped", "extended"],
)
def test_the_snippet_to_copy_makes_the_same_bytes(served: Served, verb: str, options: dict[str, Any]) -> None:
    exemplar = served.exemplar(rock=png(pixels(40, 44)))["id"]
    result = served.done(verb, [exemplar], **options)
    Path("rock.png").write_bytes(png(pixels(40, 44)))
    assert ("ia.synthesize" in result["python"]) == (verb == "grow" and "crop" not in options)
    program = result["python"].replace("['intarsia'", f"[{sys.executable!r}, '-m', 'intarsia'")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    name = result["files"][-1]["name"]
    data = served.files(result)[name]
    if "method" in options:
        assert Path(name).read_bytes() == data
    else:  # the recipe of a method that was chosen tells how, besides
        Path("served.png").write_bytes(data)
        assert np.array_equal(opened(data), opened(Path(name).read_bytes()))
        recipe = files.read_recipe("served.png")
        assert recipe.pop("auto")
        assert recipe == files.read_recipe(name)


def shown(height: int = 32, width: int = 36) -> np.ndarray:
    return np.where(np.mgrid[:height, :width][1] < 4, 0, 255).astype(np.uint8)


ASKED: dict[str, Callable[[Served], tuple[str, dict[str, Any]]]] = {
    "plain": lambda served: ("grow", QUICK),
    "avoid": lambda served: ("grow", QUICK | {"mask": [served.image(shown())], "seed": 3}),
    "jitter": lambda served: (
        "grow", {"method": "parallel-controllable", "size": "48x40", "jitter_output": served.image(shown(40, 48))}
    ),
    "heal": lambda served: ("heal", {"mask": [served.image(hole())], "patch": "6", "method": "image-quilting"}),
    "paint": lambda served: (
        "paint",
        {
            "labels": [served.image(left() // 255)], "target": served.image(left(28, 30) // 255),
            "method": "image-quilting", "patch": 8,
        },
    ),
}  # fmt: skip


def run_again(script: str) -> None:
    """Run a script of an archive: it makes the two planes that lie in the folder of what was made."""
    env = os.environ | {"PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])}
    done = subprocess.run(["sh", script], capture_output=True, text=True, env=env, check=False)
    assert done.returncode == 0, done.stderr
    made = [path for path in Path("made").iterdir() if path.name != "map.npz"]
    assert len(made) == 2
    for path in made:
        assert Path(path.name).read_bytes() == path.read_bytes(), path


@pytest.mark.parametrize("case", ASKED)
def test_the_command_makes_the_same_bytes_beside_what_the_archive_holds(case: str, served: Served) -> None:
    verb, options = ASKED[case](served)
    files_sent = {"wall_albedo": png(pixels()), "wall_height": png(left())}
    result = served.done(verb, [served.exemplar(**files_sent)["id"]], **options)
    with zipfile.ZipFile(io.BytesIO(served.bytes(f"/api/results/{result['id']}/all.zip"))) as archive:
        archive.extractall()
    assert set(result["inputs"]) == {path.name for path in Path().iterdir()} - {"made", "command.txt"}
    run_again("command.txt")


def test_the_archive_of_a_third_step_runs_all_three(served: Served) -> None:
    """Each step has its inputs of equal names in a folder of its own."""
    slopes = np.dstack([pixels()[..., 0], left(), left()])
    name = served.exemplar(wall_albedo=png(pixels()), wall_nor_dx=png(slopes))["id"]
    results = []
    for mask in (hole(), np.roll(hole(), 9, 1)):
        asked = {"mask": [served.image(mask)], "patch": "6", "method": "image-quilting"}
        results.append(served.done("heal", [name], **asked))
        name = served.post("/api/exemplars", {"result": results[-1]["id"]})["id"]
    last = served.done("extend", [name], right=12, method="image-quilting", patch="8")
    with zipfile.ZipFile(io.BytesIO(served.bytes(f"/api/results/{last['id']}/all.zip"))) as archive:
        archive.extractall()
    assert sorted(path.name for path in Path().iterdir() if path.is_dir()) == ["1-heal", "2-heal", "made"]
    for home in (Path("2-heal"), Path()):
        taken = [path for path in home.iterdir() if path.name.startswith("wall_healed")]
        assert len(taken) == 2
        for path in taken:  # what a step makes is what the next one is made of
            path.unlink()
    run_again("steps.txt")
    for home, result in (("1-heal", results[0]), ("2-heal", results[1])):
        for file, data in served.files(result).items():
            assert file == "map.npz" or Path(home, file).read_bytes() == data


def test_a_result_that_is_drawn_again_is_so_beside_its_archive(served: Served, small: str) -> None:
    grown = served.done("grow", [small], **QUICK)
    softer = served.done("render", [small], map=grown["id"], feather=3)
    with zipfile.ZipFile(io.BytesIO(served.bytes(f"/api/results/{softer['id']}/all.zip"))) as archive:
        archive.extractall()
    by_command(Path("command.txt").read_text().removeprefix("intarsia "))
    (made,) = Path("made").iterdir()
    assert Path(made.name).read_bytes() == made.read_bytes()
