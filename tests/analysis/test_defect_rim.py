"""A rim of a defect that a mask left out is seen; parts of the texture that a hole happens to touch are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

import intarsia as ia
from intarsia.analysis import defect_rim, features
from intarsia.cli import cli
from intarsia.foundation.run import draw
from intarsia.tasks.completion import dilated_hole

Mask = NDArray[np.bool_]


def disc(height: int, width: int, y: float, x: float, radius: float) -> Mask:
    rows, columns = np.mgrid[:height, :width]
    return np.asarray((rows - y) ** 2 + (columns - x) ** 2 < radius * radius)


def stained(colour: tuple[int, int, int] = (200, 20, 160)) -> NDArray[np.uint8]:
    """Stones with a disc of 40 px of another colour."""
    pixels = np.array(ia.read("sample:stones").base)[:, :, :3]
    pixels[disc(*pixels.shape[:2], 90, 150, 40)] = colour
    return pixels


def rim_of(pixels: NDArray[np.uint8], hole: Mask) -> int:
    return defect_rim.defect_rim(features.features([ia.Exemplar.of(pixels)]).pictures[0], hole)


@pytest.mark.parametrize("left", [2, 5, 9])
def test_a_rim_is_seen_and_what_is_told_covers_it(left: int) -> None:
    pixels = stained()
    hole = disc(*pixels.shape[:2], 90, 150, 40 - left)
    more = rim_of(pixels, hole)
    defect = disc(*pixels.shape[:2], 90, 150, 40)
    assert left <= more <= left + 6
    assert not (defect & ~dilated_hole(hole, more)).any()
    assert rim_of(pixels, dilated_hole(hole, more)) == 0


@pytest.mark.parametrize(
    ("x", "radius", "more", "least", "most"),
    [(146, 41, 0, 2, 9), (150, 6, 0, 0, 0), (150, 40, 0, 0, 0), (150, 43, 0, 0, 0), (150, 30, 110, 0, 0)],
    ids=["one side is left out", "it goes on beyond the reach", "all is covered", "more is covered", "nothing is left"],
)
def test_a_rim_is_what_is_left_of_a_defect(x: int, radius: int, more: int, least: int, most: int) -> None:
    pixels = stained()
    hole = disc(*pixels.shape[:2], 90, x, radius)
    assert least <= rim_of(pixels, binary_dilation(hole, iterations=more) if more else hole) <= most


def round_holes(height: int, width: int, count: int) -> list[Mask]:
    """Holes of 3 to 13 % of the shorter side, anywhere."""
    out = []
    for k in range(count):
        a, b, c = (int(draw(7, 99, k, n, 0) % 1000) / 1000 for n in range(3))
        radius = min(height, width) * (0.03 + 0.1 * a)
        out.append(disc(height, width, radius + b * (height - 2 * radius), radius + c * (width - 2 * radius), radius))
    return out


@pytest.mark.parametrize("name", ["stones", "tiles", "pebbles", "planks", "gravel", "grass", "brick"])
def test_round_holes_in_built_in_textures_have_no_rim(name: str) -> None:
    picture = features.features([ia.read(f"sample:{name}")]).pictures[0]
    for hole in round_holes(*picture.shape[:2], 12):
        assert defect_rim.defect_rim(picture, hole) == 0


def test_round_holes_in_photographs_have_hardly_ever_a_rim(textures: dict[str, Path], thorough: bool) -> None:
    """At most one in 200; of every fourth photograph, none."""
    seen = asked = 0
    for name, path in [*textures.items()][:: 1 if thorough else 4]:
        if not any(word in name for word in ("mask", "labels", "normal", "defect")):
            picture = features.features([ia.read(path)]).pictures[0]
            for hole in round_holes(*picture.shape[:2], 6):
                asked += 1
                seen += defect_rim.defect_rim(picture, hole) > 0
    assert asked > (200 if thorough else 50)
    assert seen <= asked // 200


def test_with_a_number_the_command_changes_no_more_and_tells_of_a_rim(tmp_path: Path) -> None:
    pixels = stained()
    hole = disc(*pixels.shape[:2], 90, 150, 37)
    ia.write(tmp_path / "a.png", pixels)
    ia.write(tmp_path / "m.png", (hole * 255).astype(np.uint8))
    command = ["heal", str(tmp_path / "a.png"), "--mask", str(tmp_path / "m.png"), "--patch", "30", "--force"]
    done = CliRunner().invoke(cli, [*command, "--grow", "0", "-o", str(tmp_path / "out.png")])
    told = [line for line in done.stderr.splitlines() if "--grow" in line]
    assert len(told) == 1
    out = np.asarray(ia.read(tmp_path / "out.png").base)
    assert (out[~hole] == pixels[~hole]).all()
    wanted = told[0].partition("--grow ")[2].split()[0]
    done = CliRunner().invoke(cli, [*command, "--grow", wanted, "-o", str(tmp_path / "out.png")])
    assert done.exit_code == 0
    assert "--grow" not in done.stderr


def test_holes_grow_as_far_as_a_rim_is_seen(tmp_path: Path) -> None:
    pixels = stained()
    hole = disc(*pixels.shape[:2], 90, 150, 37)
    method = ia.ImageQuilting(patch=30, tolerance=0)
    more = rim_of(pixels, hole)
    one, two = ia.heal(pixels, hole, method), ia.heal(pixels, hole, method, grow=more)
    assert more > 0
    assert (one.recipe, one.map.digest) == (two.recipe, two.map.digest)
    ia.write(tmp_path / "a.png", pixels)
    ia.write(tmp_path / "m.png", (hole * 255).astype(np.uint8))
    command = ["heal", str(tmp_path / "a.png"), "--mask", str(tmp_path / "m.png"), "--patch", "30", "-q"]
    for name, grow in (("auto", []), ("said", ["--grow", "auto"]), ("n", ["--grow", str(more)])):
        done = CliRunner().invoke(cli, [*command, *grow, "-o", str(tmp_path / f"{name}.png")])
        assert done.exit_code == 0
    assert len({(tmp_path / f"{name}.png").read_bytes() for name in ("auto", "said", "n")}) == 1
    again = ["replay", str(tmp_path / "auto.png"), "--exemplar", str(tmp_path / "a.png"), "-q"]
    done = CliRunner().invoke(cli, [*again, "--mask", str(tmp_path / "m.png"), "-o", str(tmp_path / "again.png")])
    assert done.exit_code == 0
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "auto.png").read_bytes()


@pytest.mark.parametrize("grow", ["-3", "1025", "much", "2.5"])
def test_other_growths_are_refused_in_one_line(tmp_path: Path, grow: str) -> None:
    ia.write(tmp_path / "a.png", stained())
    command = ["heal", str(tmp_path / "a.png"), "--mask", str(tmp_path / "a.png"), "-o", str(tmp_path / "b.png")]
    done = CliRunner().invoke(cli, [*command, f"--grow={grow}"])
    assert done.exit_code == 2
    assert "0 to 1024 px, or auto" in done.stderr
