"""Figures are made again: panels numbered as there, and a page with claims, measures and printed numbers."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import intarsia as ia
from intarsia.analysis.features import transformed
from intarsia.testing import texture
from papers.__main__ import DOCUMENTS, main
from papers.correction2008 import varied
from papers.figures import Figure, Panel
from papers.lopez_recas2011 import failures, goodness, sampled, tile_costs
from papers.multrus2003 import avoided, costs, farness, labelled, laws
from papers.robinson2004 import pair
from papers.segments import found

ROOT = Path(__file__).resolve().parent.parent


def test_a_figure_is_written_with_its_panels_and_a_page(tmp_path: Path) -> None:
    ia.write(tmp_path / "e.png", texture(44, 44, 1, 3))
    page = main(["000", "-o", str(tmp_path / "out"), "--exemplar", str(tmp_path / "e.png"), "--only", "3.4"])
    made = {p.name for p in page.parent.iterdir()}
    assert made == {"index.html", *(f"figure_3_4_{k}.png" for k in "abc")}
    hard, soft = (np.asarray(ia.read(page.parent / f"figure_3_4_{k}.png").base.pixels) for k in "bc")
    assert hard.shape[:2] == (200, 200)
    assert (hard != soft).any(), "the same map, drawn without and with a feather"
    text = page.read_text(encoding="utf-8")
    assert "Without blending block boundaries" in text
    assert "% of the input that is seen" in text
    assert "Shown (rising: sharp c b)" in text
    with pytest.raises(SystemExit):
        main(["000", "-o", str(tmp_path), "--only", "9.9"])


@pytest.mark.parametrize("document", DOCUMENTS.values())
def test_figures_have_numbers_claims_and_functions(document: str) -> None:
    """No verdict goes by seconds."""
    made = importlib.import_module(f"papers.{document}")
    assert len({f.number for f in made.FIGURES}) == len(made.FIGURES)
    assert all(f.claim.endswith(".") and f.usual.startswith("sample:") for f in made.FIGURES)
    assert made.TITLE
    assert not [f.number for f in made.FIGURES for rule in f.rising.split("; ") if rule.startswith("s ")]


def tiles(side: int, pitch: int) -> ia.Exemplar:
    """Dark joints on a grid, a little of grain on the tiles."""
    grid = np.where((np.mgrid[:side, :side] % pitch < 3).any(axis=0), 20, 120).astype(np.uint8)
    return ia.Exemplar.of(grid + texture(side, side, 1, 4)[..., 0] // 8)


def values_of(panels: list[Panel], letters: str) -> dict[str, dict[str, float]]:
    return {letter: panel.values for letter, panel in zip(letters, panels, strict=True)}


def test_a_verdict_holds_where_the_measures_rise_along_the_panels() -> None:
    picture = ia.Plane(np.zeros((2, 2), np.uint8))
    panels = [Panel("", picture, {"s": v, "seams": 9 - v}) for v in (1.0, 2.0, 2.0)]
    told = {"s b c": "Shown", "s c b": "Not shown", "s b c; seams b c": "Partly shown", "s c d": "Not shown"}
    for rising, said in (told | {"s 0.5 b c 3": "Shown", "": "To be judged"}).items():
        assert Figure("1", "", lambda _: [], rising, letters="bcd").verdict(panels).startswith(said), rising


def test_the_distance_of_the_seam_is_that_of_the_best_pose() -> None:
    """By the formula of 3.3.3, every block of the input laid down in every pose."""
    pixels, block = (texture(n, n, 2, 6).astype(np.float64) for n in (14, 9))
    known = np.ones((9, 9), bool)
    known[5:, 5:] = False
    poses = (0, 3, 4, 5, 7)
    far = farness(pixels, block, poses)
    assert far.shape == (6, 6)
    for y, x in np.ndindex(far.shape):
        laid = [transformed(pixels[y : y + 9, x : x + 9], pose) for pose in poses]
        best = min(((one - block)[known] ** 2).sum() for one in laid)
        assert far[y, x] == pytest.approx(np.sqrt(best / known.sum()))


def test_marked_pixels_do_not_come_into_the_picture_and_labels_are_followed() -> None:
    e = ia.Exemplar.of(texture(130, 130, 1, 3) // 2 + 60)
    assert values_of(avoided(e), "c")["c"]["marked"] == 0
    made = labelled(e, 90, 0.4, {1.5: "", 0: ""}, patch=7, overlap=4)
    agree = {k: v["agree"] for k, v in values_of(made, "acde").items() if v}
    assert agree["d"] > max(97, agree["e"])


def test_the_tile_itself_is_best_and_the_best_tile_repeats_at_less_cost_than_the_worst() -> None:
    e = tiles(110, 22)
    good = {k: v["goodness"] for k, v in values_of(goodness(e), "abcd").items() if v}
    assert good["b"] > max(good["c"], good["d"])
    pixels = np.asarray(sampled(e)[0].picture.pixels)  # every second block is empty at first
    assert pixels[:40, :40].all()
    assert not pixels[:40, 40:80].any()
    _, best, worst = tile_costs(e)
    assert best.values["cost"] < worst.values["cost"]
    pixels = np.asarray(best.picture.pixels)
    assert (pixels[:-22] == pixels[22:]).all()
    assert (pixels[:, :-22] == pixels[:, 22:]).all()


def test_quilting_meets_better_than_random_tiling() -> None:
    made = values_of(pair(24, 4)(tiles(60, 15)), "bc")
    assert made["c"]["seams"] < made["b"]["seams"]


def test_patch_and_zone_of_dots_are_found_in_time() -> None:
    y, x = np.mgrid[:120, :120]
    dots = np.where(np.hypot(y % 24 - 12, x % 24 - 12) < 8, 40, 200).astype(np.uint8)
    values = found(ia.Exemplar.of(dots))[1].values
    assert abs(values["a"] - 24) <= 2
    assert 0 < values["b"] < values["a"] / 2


def test_the_laws_count_what_the_searches_do_and_their_curves_are_drawn() -> None:
    """By 2.3, 3.4 and 4.3.2 of the thesis, at a side of 200 px, with all operations counted one by one."""
    found = {name: int(n[0]) for name, n in laws(np.array([200])).items()}
    blocks, coarse = 166**2 * 10 * 35, 43**2 * 2 * 8 + 17**2 * 4 * 16 + 36**2 * 10 * 35
    assert found == {"pixels": 200**2 * 313, "blocks": blocks // 35**2, "pyramid": coarse // 35**2}
    (one,), (three,) = (costs(ia.Exemplar.of(texture(8, 8, 1, 2)), n) for n in (1, 3))
    assert one.values["growth"] == 64
    assert three.values["gain"] > 10
    ink = [(np.asarray(panel.picture.pixels)[:, 60:440] == 0).sum() for panel in (one, three)]
    assert 0 < ink[0] < ink[1]


def test_the_rule_for_lattices_fails_as_the_thesis_says() -> None:
    tiles = {k: v["tiles"] for k, v in values_of(failures(ia.Exemplar.of(texture(8, 8, 1, 2))), "acdf").items()}
    assert tiles["c"] == tiles["d"] == pytest.approx(0.5)
    assert tiles["f"] > 2


def test_a_dearer_jump_set_leaves_larger_pieces() -> None:
    values = values_of(varied("kappa", 1.0, 2.0, "inf")(ia.Exemplar.of(texture(48, 48, 3, 8))), "abcd")
    assert values["b"]["whole"] < values["d"]["whole"]


def test_the_command_writes_a_page_and_tells_errors_in_one_line(tmp_path: Path) -> None:
    ia.write(tmp_path / "e.png", np.asarray(tiles(64, 16).base.pixels))
    words = [sys.executable, "-m", "benchmarks.papers", "003", "--exemplar", str(tmp_path / "e.png"), "--only", "1"]
    words += ["-o", str(tmp_path / "o")]
    done = [subprocess.run(words, capture_output=True, text=True, cwd=ROOT) for _ in (1, 2)]
    assert [one.returncode for one in done] == [0, 2], done
    assert sorted(p.name for p in (tmp_path / "o").iterdir()) == ["figure_1_a.png", "figure_1_b.png", "index.html"]
    assert done[1].stderr.startswith("intarsia: ")
    assert done[1].stderr.count("\n") == 1, "what is there is not written over"


def test_all_documents_are_made_each_in_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    monkeypatch.setattr("papers.__main__.write", lambda title, figures, e, out: asked.append(out) or out)
    main(["all", "-o", str(tmp_path)])
    assert asked == [tmp_path / document for document in DOCUMENTS]
