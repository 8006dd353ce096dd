"""Whatever lies in a file, reading it gives a picture or one InputError of one line; never anything else."""

from __future__ import annotations

import resource
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from corpus import CASES, OK, REFUSED, picture, pillow, png

from intarsia.errors import InputError
from intarsia.files import read, read_plane, read_recipe


@pytest.mark.parametrize("name", CASES)
def test_every_bad_file_reads_or_is_refused_in_one_line(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    case = CASES[name]
    path = case.make(tmp_path)
    start = time.monotonic()
    message = ""
    try:
        plane = read_plane(path)
        assert plane.height >= 1
        assert plane.width >= 1
    except InputError as e:
        message = str(e)
    assert time.monotonic() - start < 5
    assert not (case.outcome == OK and message), message
    assert not (case.outcome == REFUSED and not message), "it was read"
    if message:
        assert "\n" not in message
        assert len(message) < 500
        assert message.endswith(".")
        assert "Traceback" not in message
    if case.outcome != "either" and name != "short-idat.png":  # libpng speaks of that one itself
        assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", [n for n in CASES if n.startswith(("cut-8", "flip-1", "a ", "bomb"))])
def test_bad_files_have_no_recipe(name: str, tmp_path: Path) -> None:
    path = CASES[name].make(tmp_path)
    with suppress(InputError):
        assert read_recipe(path) is None


@pytest.mark.parametrize("name", ["cut-8-of-16.png", "a folder", "zip.png", "palette.png", "cmyk.jpg", "16-big.tif"])
def test_bytes_are_treated_as_files_are(name: str, tmp_path: Path) -> None:
    path = CASES[name].make(tmp_path)
    if path.is_dir():
        return
    try:
        expected = read_plane(path).pixels
    except InputError:
        with pytest.raises(InputError, match="the data"):
            read_plane(path.read_bytes())
        return
    np.testing.assert_array_equal(read_plane(path.read_bytes()).pixels, expected)


def test_bombs_are_refused_without_memory(tmp_path: Path) -> None:
    for name in (n for n in CASES if n.startswith(("bomb", "tall", "wide", "strips", "lying"))):
        path = CASES[name].make(tmp_path)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with pytest.raises(InputError):
            read_plane(path)
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        assert grown < 700_000, name  # KiB


def test_messages_say_what_it_seems_to_be(tmp_path: Path) -> None:
    for name, word in (("zip.png", "zip"), ("plain.svg", "SVG"), ("layers.psd", "Photoshop"), ("paper.pdf", "PDF")):
        with pytest.raises(InputError, match=word):
            read_plane(CASES[name].make(tmp_path))


def test_a_file_without_permission_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "closed.png"
    path.write_bytes(png(4, 4))

    def refuse(*_: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("os.open", refuse)
    with pytest.raises(InputError, match="permission denied"):
        read_plane(path)


def test_nan_under_the_mask_is_allowed(tmp_path: Path) -> None:
    from intarsia.files import write

    values = np.ones((4, 4, 3), np.float32)
    values[0, 0] = np.nan
    write(tmp_path / "a.exr", values)
    with pytest.raises(InputError, match="NaN"):
        read(tmp_path / "a.exr")
    mask = np.full((4, 4), 255, np.uint8)
    mask[0, 0] = 0
    (tmp_path / "m.png").write_bytes(pillow("png", mask))
    assert read(tmp_path / "a.exr", mask=tmp_path / "m.png").usable is not None


def test_masks_of_another_size_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(pillow("png", picture(8, 8)))
    (tmp_path / "m.png").write_bytes(pillow("png", picture(8, 9, 1)))
    with pytest.raises(InputError, match="make them equal"):
        read(tmp_path / "a.png", mask=tmp_path / "m.png")
