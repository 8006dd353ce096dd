"""``grow --distance-map``: distances as numbers or as a picture, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import intarsia as ia
from intarsia.cli.verbs import command_of
from intarsia.foundation import IntarsiaError

ARGS = ["sample:pebbles", "--crop", "0,0,60,50", "--size", "60"]
ARGS += ["-m", "patch-sampling", "--patch", "9", "--overlap", "4"]


def grow(folder: Path, name: str, place: str = "30,30", *more: str) -> None:
    out = ["-o", str(folder / f"{name}.out.png"), "--distance-map", place, str(folder / name), "--threads", "1"]
    CliRunner().invoke(command_of("grow"), [*ARGS, *out, *more], catch_exceptions=False, standalone_mode=False)


def test_float_files_hold_distances_and_png_stretches_them(tmp_path: Path) -> None:
    for name in ("d.exr", "d.tif", "d.png"):
        grow(tmp_path, name)
    exr, tif, png = (np.asarray(ia.read(tmp_path / n).base).astype(float) for n in ("d.exr", "d.tif", "d.png"))
    assert exr.shape == (50 - 16, 60 - 16)
    assert 0 <= exr.min() < exr.max() <= 1
    np.testing.assert_array_equal(exr, tif)
    np.testing.assert_allclose(png, (exr - exr.min()) / (exr.max() - exr.min()) * 65535, atol=0.6)


@pytest.mark.parametrize(
    ("name", "place", "more", "words"),
    [
        ("d.exr", "60,3", (), "outside"),
        ("d.jpg", "3,3", (), r"\.png"),
        ("d.png", "3,3", ("-m", "repeat"), "measures no"),
    ],
)
def test_what_cannot_be_answered_is_refused_before_any_work(
    tmp_path: Path, name: str, place: str, more: tuple[str, ...], words: str
) -> None:
    args = [a for a in ARGS if not more or a not in ("--patch", "9", "--overlap", "4")]
    out = ["-o", str(tmp_path / "o.png"), "--distance-map", place, str(tmp_path / name), *more]
    with pytest.raises(IntarsiaError, match=words):
        CliRunner().invoke(command_of("grow"), [*args, *out], catch_exceptions=False, standalone_mode=False)
    assert not list(tmp_path.iterdir())
