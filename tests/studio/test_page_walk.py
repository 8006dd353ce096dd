"""The whole way of a first visit: a material is opened, painted, grown so that it tiles, lit, and taken."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from studio.browser import Desk

pytest.importorskip("playwright.sync_api", reason="no playwright")


def test_from_nothing_to_a_painted_tileable_lit_material_set(page: Desk) -> None:
    page.sample("setts")
    page.room("Paint")
    page.still()
    page.button("Label 2").click()
    page.stroke((60, 60), (200, 200))
    page.button("Label 2").click()
    page.stroke((60, 120), (120, 60), (180, 110), number=1)  # off the border: labels that jump there show
    page.page.get_by_role("spinbutton", name="Width in px").fill("256")
    page.page.get_by_role("spinbutton", name="Height in px").fill("192")
    page.radio("Both").click()
    page.button("Grow").click()
    page.grown()
    page.radio("Lit").click()
    lamp = page.page.get_by_role("slider", name="Lamp")
    lamp.wait_for()
    lit = page.still()
    lamp.focus()
    page.page.keyboard.press("Shift+ArrowRight")
    assert not np.array_equal(page.seen(), lit)
    page.button("3 × 3").click()
    page.button("More to take").click()
    with page.page.expect_download() as taken:
        page.page.get_by_role("link", name="All as a zip").click()
    with zipfile.ZipFile(Path(taken.value.path())) as archive:
        names = archive.namelist()
        pictures = [name for name in names if name.endswith(".png")]
        planes = {name: np.asarray(Image.open(io.BytesIO(archive.read(name)))) for name in pictures if "/" in name}
    ends = ("", "_height", "_normal", "_roughness")
    assert sorted(planes) == sorted(f"made/setts_painted{end}.png" for end in ends)
    assert set(pictures) - set(planes) == {"labels.png", "target.png"}
    assert all(pixels.shape[:2] == (192, 256) for pixels in planes.values())
    assert planes["made/setts_painted_height.png"].dtype in (np.uint16, np.int32)
    assert {"command.txt", "made/map.npz"} <= set(names)
    base = planes["made/setts_painted.png"].astype(int)
    for axis in (0, 1):  # it continues in itself: what meets at the border differs no more than neighbours do
        steps = np.abs(np.diff(base, axis=axis)).mean(axis=(1 - axis, 2))
        assert np.abs(base.take(0, axis) - base.take(-1, axis)).mean() <= steps.max()
