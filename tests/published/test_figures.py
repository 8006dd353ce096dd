"""Figures are made again: panels numbered as there, and a page with claims, measures and printed numbers."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

import intarsia as ia
from intarsia.published.__main__ import DOCUMENTS, main
from intarsia.testing import texture


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
    assert "% of the input shown" in text


@pytest.mark.parametrize("document", DOCUMENTS.values())
def test_figures_have_numbers_claims_and_functions_of_their_own(document: str) -> None:
    made = importlib.import_module(f"intarsia.published.{document}.figures")
    assert len({f.number for f in made.FIGURES}) == len({f.panels for f in made.FIGURES}) == len(made.FIGURES)
    assert all(f.claim.endswith(".") for f in made.FIGURES)
    assert made.TITLE
    assert all(f.usual.startswith("sample:") for f in made.FIGURES)


def test_figures_of_near_regular_textures_and_of_quilting_are_written(tmp_path: Path) -> None:
    """Of a document each one figure: its panels are there, in their sizes."""
    tiles = np.where((np.mgrid[:110, :110] % 22 < 3).any(axis=0), 20, 120).astype(np.uint8)
    ia.write(tmp_path / "e.png", tiles + texture(110, 110, 1, 4)[..., 0] // 8)
    for document, number, last, size in (("001", "5.12", "b", 400), ("002", "1", "c", 220)):
        page = main([document, "-o", str(tmp_path / document), "--exemplar", str(tmp_path / "e.png"), "--only", number])
        name = f"figure_{number.replace('.', '_')}_{last}.png"
        assert ia.read(page.parent / name).base.pixels.shape[:2] == (size, size)


def test_a_figure_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit):
        main(["000", "-o", str(tmp_path), "--only", "9.9"])
