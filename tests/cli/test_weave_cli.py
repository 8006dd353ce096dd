"""``intarsia weave``: giant pictures from the command line, refused in one line or gone on with."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from cli import commands
from click.testing import Result
from giant.giants import files_below, needs

import intarsia as ia
from intarsia import disk
from intarsia.cli import Interrupted
from intarsia.files import read_plane, read_recipe
from intarsia.giant.exports import PictureStore, TiffStore
from intarsia.testing import as_depth, texture

LAID = ["--method", "near-regular", "--lattice", "20,0 0,17", "--block", "16", "--border", "4"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    ia.write(tmp_path / "wall.png", texture(80, 77, 3, 1))
    ia.write(tmp_path / "wall_h.png", as_depth(texture(80, 77, 1, 2), "uint16"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words: str, code: int = 0) -> Result:
    return commands.run("weave", *words, code=code)


def test_what_it_writes_is_what_the_library_draws(here: Path) -> None:
    """All planes, in all formats, anywhere."""
    asked = ["-o", "{stem}_{w}.tif", "--size", "150x90", "--origin", "-7,99", "--seed", "3", "--feather", "4", "--json"]
    done = run("wall.png", "--map", "height=wall_h.png", *asked, *LAID)
    told = json.loads(done.stdout)
    assert [f["path"] for f in told["files"]] == ["wall_150.tif", "wall_150_height.tif"]
    assert (told["size"], told["origin"], told["seed"]) == ([150, 90], [-7, 99], 3)
    method = ia.NearRegular(lattice=((20, 0), (0, 17)), block=16, border=4)
    exemplar = ia.read("wall.png", height="wall_h.png")
    woven = ia.weave(exemplar, method, 3, blend=ia.Blend(4))
    assert (read_plane("wall_150.tif").pixels == woven[99:189, -7:143]).all()
    height = read_plane("wall_150_height.tif").samples
    assert (height == woven.plane("height")[99:189, -7:143].reshape(90, 150, 1)).all()
    run("wall.png", "-o", "o.png", "--size", "64", "--quiet", *LAID)
    assert (read_plane("o.png").pixels == ia.weave("wall.png", method)[0:64, 0:64]).all()


def test_a_picture_is_what_the_other_stores_are(here: Path) -> None:
    """All planes in their depth, by any number of threads, with the recipe; it replaces others only if asked."""
    words = ["wall.png", "--map", "height=wall_h.png", "--size", "1300x1100", "--origin", "-7,99", "-q", *LAID]
    for out, threads in (("o.tif", "2"), ("o.png", "1"), ("p.png", "3")):
        run(*words, "-o", out, "--threads", threads)
    for name in ("", "_height"):
        tiff, png = read_plane(f"o{name}.tif"), read_plane(f"o{name}.png")
        assert png.pixels.dtype == tiff.pixels.dtype
        assert (png.samples == tiff.samples).all()
        assert read_recipe(f"o{name}.png") == read_recipe(f"o{name}.tif")
        assert (here / f"o{name}.png").read_bytes() == (here / f"p{name}.png").read_bytes()
    assert read_recipe("o.png")["origin"] == [-7, 99]
    run(*words, "-o", "o.png", code=2)
    run(*words, "-o", "o.png", "--force", "--seed", "1")
    assert (read_plane("o.png").samples != read_plane("p.png").samples).any()
    again = commands.run("replay o.png -o r.png --exemplar wall.png", code=3)
    assert "o.png was woven; make it again with intarsia weave" in again.stderr


def test_a_picture_that_does_not_fit_into_memory_is_refused(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before anything is drawn; a TIFF of this size goes."""
    enough = disk.ESTIMATE_MARGIN * (disk.peak_memory() + (40 << 20))
    monkeypatch.setattr(disk, "_limits", lambda: iter([(int(enough), "one has")]))
    before = sorted(os.listdir(here))
    done = run("wall.png", "-o", "o.png", "--size", "2000", "--threads", "1", *LAID, code=1)
    assert "o.png: 2000x2000 px, near-regular, seed 0 takes about" in done.stderr
    assert "MiB; name a .zarr or a .tif, which need not fit." in done.stderr
    assert sorted(os.listdir(here)) == before
    run("wall.png", "-o", "o.tif", "--size", "2000", "--threads", "1", "-q", *LAID)


@pytest.mark.parametrize("name", ["SIGINT", "SIGKILL"])
@pytest.mark.parametrize("out", ["o.png", "o.tif"])
def test_a_picture_that_is_stopped_leaves_nothing(out: str, name: str, here: Path) -> None:
    """Of a kill nothing but what the next start sweeps."""
    before = sorted(os.listdir(here))
    words = ["wall.png", "-o", out, "--size", "9000", "--threads", "1", "--progress", "json", *LAID]
    command = [sys.executable, "-m", "intarsia", "weave", *words]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as begun:
        assert begun.stderr is not None
        assert any('"done": 1,' in line for line in begun.stderr)
        begun.send_signal(getattr(signal, name))
        told = begun.stderr.read()
    if (name, out) == ("SIGKILL", "o.tif"):
        assert len(os.listdir(here)) == len(before) + 1
        words = ["wall.png", "-o", out, "--size", "64", "-q", *LAID]
        assert subprocess.run([sys.executable, "-m", "intarsia", "weave", *words], check=False).returncode == 0
        os.unlink(out)
    assert sorted(os.listdir(here)) == before
    if name == "SIGINT":
        assert begun.returncode == 130
        said = {"error": "stopped; nothing was written, and the same command begins anew.", "kind": "stopped"}
        assert json.loads(told.splitlines()[-1]) == said | {"exit_code": 130}


@pytest.mark.parametrize("out", ["o.png", "o.tif"])
def test_of_planes_that_are_stopped_none_is_left(out: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first is whole by then."""
    before, kind = sorted(os.listdir(here)), {"o.png": PictureStore, "o.tif": TiffStore}[out]
    fill = kind.fill

    def filled(store: PictureStore, *given: Any) -> None:
        if "_height" in store.path.name:
            raise Interrupted
        fill(store, *given)

    monkeypatch.setattr(kind, "fill", filled)
    done = run("wall.png", "--map", "height=wall_h.png", "-o", out, "--size", "64", *LAID, code=130)
    assert done.stderr.splitlines()[-1].endswith("stopped; nothing was written, and the same command begins anew.")
    assert sorted(os.listdir(here)) == before


def test_zarr_by_dask(here: Path) -> None:
    zarr = needs("zarr")
    needs("distributed")
    words = ["wall.png", "-o", "o.zarr", "--size", "90", "--chunk", "32", "--threads", "2", "--dask", "local", *LAID]
    assert subprocess.run([sys.executable, "-m", "intarsia", "weave", "-q", *words], check=False).returncode == 0
    method = ia.NearRegular(lattice=((20, 0), (0, 17)), block=16, border=4)
    stored = zarr.open_array(here / "o.zarr", mode="r")[:]
    assert (stored == ia.weave("wall.png", method)[0:90, 0:90]).all()


def test_a_dry_run_tells_size_memory_and_time_and_writes_nothing(here: Path) -> None:
    before = sorted(os.listdir(here))
    done = run("wall.png", "-o", "o.tif", "--size", "65536", "--dry-run", "--json", *LAID)
    told = json.loads(done.stdout)
    assert told["pixels_bytes"] == 3 * 65536**2
    assert told["cells"] == 4096
    assert told["seconds"] > 1
    assert told["memory_mib"] > 0  # of this process; test_estimate.py compares it with the peak of one of its own
    assert "65536x65536 px, near-regular, seed 0, 12288 MiB of pixels, about" in done.stderr
    assert sorted(os.listdir(here)) == before


def test_progress_is_told_as_json(here: Path) -> None:
    done = run("wall.png", "-o", "o.png", "--size", "1100", "--progress", "json", *LAID)
    lines = [line for line in map(json.loads, done.stderr.splitlines()) if "stage" in line]
    assert [line["done"] for line in lines if line["stage"] == "weave"][-1] == 4
    assert lines[-1]["fraction"] == 1.0


REFUSED = [
    ("-o o.jp2", 2, "-o o.jp2: name a .zarr, a .tif, or a picture such as .png."),
    ("-o o", 2, "-o o: name a .zarr, a .tif, or a picture such as .png."),
    ("-o wall.png", 2, "wall.png exists; name another file, or allow to replace it with --force"),
    ("-o missing/o.png", 3, "missing does not exist; make it first, or name another."),
    ("-o o.png --chunk 64", 2, "o.png: a picture in one piece has no chunks; drop --chunk, or name a .zarr"),
    ("-o o.pfm", 2, "o.pfm: pfm holds float, not 8 bit; name a .zarr or a .tif."),
    ("-o -", 2, "-o -: a giant picture does not fit into a pipe"), ("-o o{colour}.tif", 2, "{colour} is unknown"),
    ("-o missing/o.tif", 3, "missing does not exist; make it first, or name another."),
    ("-o missing/o.zarr", 3, "missing does not exist; make it first, or name another."),
    ("-o o.tif --dask nowhere", 2, "dask='nowhere' is unknown; give local, the tcp:// address of a dask"),
    ("-o o.tif --origin 1099511627776,0", 2, "lie too far away; stay within 2**40 px."),
    ("-o o.tif --method image-quilting", 2, "'image-quilting' is not one of"),
    ("-o o.tif --patch 40", 2, "No such option"),
    ("-o o.tif --chunk 40", 2, "tile=40 is not allowed; give 16 to 4096 px, a multiple of 16."),
    ("-o o.tif --size 1e9", 2, "1e9 is no size"),
]  # fmt: skip


@pytest.mark.parametrize(("words", "code", "message"), REFUSED)
def test_bad_input_is_one_line(words: str, code: int, message: str, here: Path) -> None:
    needs("distributed")
    before = sorted(os.listdir(here))
    done = run("wall.png", *([] if "--size" in words else ["--size", "64"]), *words.split(), code=code)
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert sorted(os.listdir(here)) == before


def test_a_missing_extra_exits_with_5(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module, words in (
        ("zarr", ["-o", "o.zarr"]), ("tifffile", ["-o", "o.tif"]), ("distributed", ["-o", "o.tif", "--dask", "local"]),
    ):  # fmt: skip
        monkeypatch.setitem(sys.modules, module, None)
        done = run("wall.png", "--size", "64", *words, *LAID, code=5)
        assert done.stderr == f"intarsia: {module} is not installed; run: pip install 'intarsia[giant]'\n"


def test_another_recipe_is_refused(here: Path) -> None:
    needs("zarr")
    words = ["wall.png", "-o", "o.zarr", "--size", "64", "-q", *LAID]
    run(*words)
    for more in ([], ["--force"]):
        done = run(*words, "--seed", "1", *more, code=2)
        assert "o.zarr holds another recipe (seed); name another place, or remove it first." in done.stderr
    run(*words)


def test_what_ctrl_c_stops_the_same_command_goes_on_with(here: Path) -> None:
    zarr = needs("zarr")
    words = [sys.executable, "-m", "intarsia", "weave", "wall.png", "--size", "1500", "--threads", "2", *LAID]
    assert subprocess.run([*words, "-q", "-o", "whole.zarr"], check=False).returncode == 0
    begun = subprocess.Popen([*words, "-o", "o.zarr"], stderr=subprocess.PIPE, text=True)
    while begun.poll() is None and not list(here.glob("o.zarr/c/*/*/0")):
        time.sleep(0.01)
    begun.send_signal(signal.SIGINT)
    told = begun.communicate()[1]
    if begun.returncode != 0:  # it may have been done already
        assert begun.returncode == 130
        assert told.splitlines()[-1] == "intarsia: stopped; the same command goes on where it was."
    assert subprocess.run([*words, "-q", "-o", "o.zarr"], check=False).returncode == 0
    assert files_below(here / "o.zarr") == files_below(here / "whole.zarr")
    assert zarr.open_array(here / "o.zarr", mode="r").shape == (1500, 1500, 3)
