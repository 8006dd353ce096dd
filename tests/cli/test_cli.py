"""The command line does what the library does, writes all files or none, and imports little before it must."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli.commands import run, told
from numpy.typing import NDArray

import intarsia as ia
from intarsia import files
from intarsia.cli import COMMANDS
from intarsia.foundation import SAMPLES
from intarsia.methods import METHODS
from intarsia.model.image import Transfer


def pixels(path: Path) -> NDArray[Any]:
    return files.read_plane(path).pixels


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    rows, columns = np.mgrid[:40, :48]
    noise = (rows * 7919 + columns * 104729 + rows * columns * 31) % 65521
    colour = np.stack([noise, noise // 2, 65535 - noise], axis=2).astype(np.uint16)
    files.write("deep.png", ia.Plane(colour))
    files.write("a.png", ia.Plane((colour // 257).astype(np.uint8)))
    files.write("b.png", ia.Plane((colour[::-1] // 257).astype(np.uint8)))
    files.write("n.png", ia.Plane(np.full((40, 48, 3), [128, 128, 255], np.uint8)))
    height = (noise / 65521).astype(np.float16)
    files.write("h.exr", ia.Plane(height, ia.Kind.DATA, Transfer.LINEAR))
    mask = np.full((40, 48), 255, np.uint8)
    mask[:10] = 0
    files.write("mask.png", ia.Plane(mask))


GROW = ("grow", "a.png", "-q", "--size", "64x50", "--patch", "12")


class TestListings:
    def test_help_names_every_command_and_the_completion(self) -> None:
        text = run("--help").stdout
        assert all(name in text for name in COMMANDS)
        assert "_INTARSIA_COMPLETE=bash_source" in text
        assert run().stdout == text

    def test_grow_lists_the_samples(self) -> None:
        text = run("grow", "--help-all").stdout
        assert sorted(SAMPLES) == files.sample_names()
        assert all(f"sample:{name}" in said for name in SAMPLES for said in (text, run("grow", "--help").stdout))

    def test_methods_and_version(self) -> None:
        assert run("--version").stdout == f"intarsia {ia.__version__}\n"
        entries = json.loads(run("methods", "--json").stdout)
        assert [e["slug"] for e in entries] == list(METHODS)
        assert {"slug", "paper", "supports", "parameters"} <= set(entries[0])
        assert {"name", "kind", "default", "low", "high", "unit", "choices", "help"} == set(entries[0]["parameters"][0])
        assert len(run("methods").stdout.splitlines()) == len(METHODS)
        assert "--patch" in run("methods", "image-quilting").stdout
        assert len(json.loads(run("methods", "image-quilting", "--json").stdout)) == 1

    def test_listings_and_usage_errors_import_nothing_heavy(self) -> None:
        script = """
import os, sys
from click.testing import CliRunner
from intarsia.cli import cli
from intarsia.cli import COMMANDS
calls = [["--help"], *([name, "-h"] for name in COMMANDS), *([name, "--frobnicate"] for name in COMMANDS),
         *([name, "--help-all"] for name in COMMANDS), ["grow", "-m", "graphcut", "--help"],
         ["methods"], ["methods", "image-quilting", "--json"], ["--version"], ["nonsense"], ["grow"],
         ["grow", "a", "-o", "b", "--size", "x"], ["grow", "a.png", "-o", "b.png", "--patch", "0"],
         ["grow", "a.png", "-o", "b.png", "--method", "repeat", "--patch", "9"],
         ["analyze"], ["analyze", "a.png", "--crop", "nonsense"]]
for call in calls:
    assert CliRunner().invoke(cli, call).exit_code in (0, 2), call
os.environ.update(_INTARSIA_COMPLETE="bash_complete", COMP_WORDS="intarsia grow --me", COMP_CWORD="2")
result = CliRunner().invoke(cli, [])
assert "--method" in result.stdout, result.stdout
heavy = {"numpy", "numba", "scipy", "skimage", "PIL", "OpenImageIO", "rich"} & set(sys.modules)
assert not heavy, heavy
"""
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr

    def test_a_method_that_is_named_imports_no_other_and_nothing_that_is_not_asked_for(self) -> None:
        script = """
import sys
from click.testing import CliRunner
from intarsia.cli import cli
line = ["grow", "a.png", "-o", "named.png", "-s", "30", "-m", "image-quilting"]
assert CliRunner().invoke(cli, line).exit_code == 0
mine = sorted(name for name in sys.modules if name.startswith("intarsia."))
print(*mine, sep="\\n")
"""
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
        found = set(done.stdout.split())
        methods = {name for name in found if name.startswith("intarsia.methods.")}
        assert methods == {"intarsia.methods.image_quilting"}, done.stderr
        rooms = {name.split(".")[1] for name in found}
        assert not rooms & {"published", "regular", "corrections", "judging", "studio", "giant"}
        rare = "rendering.seam_levelling rendering.warped_kernels seams.repair seams.graphcut_textures search.guide"
        rare += " tasks.completion"
        assert not found & {f"intarsia.{name}" for name in rare.split()}

    def test_a_parameter_of_another_method_is_told_of_by_the_method_that_is_named(self) -> None:
        said = run("grow", "a.png", "-o", "b.png", "-m", "image-quilting", "--lattice", "9,0", code=2)
        assert "lattice: image-quilting has no such parameter; it has patch" in said.stderr
        said = run("grow", "a.png", "-o", "b.png", "-m", "image-quilting", "--frobnicate", "1", code=2)
        assert "No such option '--frobnicate'" in said.stderr
        assert "--lattice" in run("grow", "--help-all").stdout


class TestGrow:
    def test_makes_what_the_library_makes_and_replay_repeats_it_byte_for_byte(self) -> None:
        more = ("--wrap", "both", "--overlap", 4, "--isometries", "180", "-m", "image-quilting")
        run(*GROW, "-o", "out.png", "--seed", 5, *more)
        method = ia.ImageQuilting(patch=12, overlap=4, isometries="180")
        made = ia.synthesize("a.png", (50, 64), method, seed=5, wrap="both")
        ia.write("library.png", made.render(), recipe=made.recipe_text)
        run("replay", "out.png", "--exemplar", "a.png", "-o", "again.png")
        data = Path("out.png").read_bytes()
        assert data == Path("library.png").read_bytes()
        assert data == Path("again.png").read_bytes()

    def test_sixteen_bits_stay_and_every_pixel_is_one_of_the_exemplar(self) -> None:
        run("grow", "deep.png", "-o", "out.png", "--patch", 10, "--even-tone", 0, "-q")
        out, exemplar = pixels(Path("out.png")), pixels(Path("deep.png"))
        assert out.dtype == np.uint16
        assert out.shape == (80, 96, 3)
        known = set(map(tuple, exemplar.reshape(-1, 3).tolist()))
        assert set(map(tuple, out.reshape(-1, 3).tolist())) <= known

    def test_further_planes_lie_beside_in_the_format_they_came_in(self) -> None:
        made = told(*GROW, "--map", "normal=n.png", "--map", "height=h.exr", "-o", "out.png", "--save-map", "m.npz",
                      "--even-tone", 0)  # fmt: skip
        assert [f["path"] for f in made["files"]] == ["out.png", "out_normal.png", "out_height.exr", "m.npz"]
        assert pixels(Path("out_height.exr")).dtype == np.float16
        smap = ia.SourceMap.load("m.npz")
        exemplar = pixels(Path("h.exr"))
        assert np.array_equal(pixels(Path("out_height.exr")), exemplar[smap.yx[:, :, 0], smap.yx[:, :, 1]])

    def test_json_says_what_was_done(self) -> None:
        made = told("grow", "a.png", "-q", "-o", "out.png", "-m", "image-quilting", "--size", "64x50",
                      "--patch", "14x12", "--overlap", "3x4")  # fmt: skip
        assert made["size"] == [64, 50]
        assert made["parameters"]["patch"] == [14, 12]
        assert (made["seed"], made["method"], made["wrap"]) == (0, "image-quilting", "none")
        assert made["warnings"] == []
        assert set(made["timings"]) == {"total"}
        assert made["exemplars"][0]["size"] == [48, 40]

    def test_masked_and_avoided_pixels_never_appear(self) -> None:
        exemplar = pixels(Path("a.png"))
        run(*GROW, "--mask", "mask.png", "-o", "out.png", "--save-map", "m.npz")
        assert ia.SourceMap.load("m.npz").yx[:, :, 0].min() >= 10
        picture = exemplar.copy()
        picture[5, 5] = 255, 0, 255
        files.write("pink.png", ia.Plane(picture))
        given = "-q", "-m", "image-quilting", "--patch", 9, "--avoid", "#FF00FF"
        made = told("grow", "pink.png", *given, "-o", "out2.png")
        assert made["warnings"] == []
        assert not (pixels(Path("out2.png")) == [255, 0, 255]).all(axis=2).any()
        assert "#010203" in told(*GROW, "--avoid", "#010203", "-o", "out3.png")["warnings"][0]
        run("replay", "out2.png", "-e", "pink.png", "-o", "again.png")
        assert Path("again.png").read_bytes() == Path("out2.png").read_bytes()

    def test_scale_averages_all_planes_in_their_own_way(self) -> None:
        run("grow", "a.png", "--map", "height=h.exr", "--map", "normal=n.png", "--scale", "1/4", "--method", "repeat",
            "--size", "12x10", "-q", "-o", "out.png")  # fmt: skip
        height = pixels(Path("h.exr")).astype(np.float64).reshape(10, 4, 12, 4).mean(axis=(1, 3))
        assert np.allclose(pixels(Path("out_height.exr")), height, atol=1e-3)
        assert (pixels(Path("out_normal.png")) == [128, 128, 255]).all()
        exemplar = ia.Exemplar.of(pixels(Path("a.png")))
        light = np.where((v := exemplar.base.pixels / 255) <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
        mean = light.reshape(10, 4, 12, 4, 3).mean(axis=(1, 3))
        code = np.where(mean <= 0.0031308, 12.92 * mean, 1.055 * mean ** (1 / 2.4) - 0.055) * 255
        assert np.abs(pixels(Path("out.png")) - code).max() < 0.51
        made = told("grow", "a.png", "--scale", "1/7", "--method", "repeat", "-q", "-o", "seventh.png")
        assert made["exemplars"][0]["size"] == [6, 5]

    def test_a_crop_hits_smaller_planes(self) -> None:
        small = np.arange(20 * 24, dtype=np.uint8).reshape(20, 24)
        files.write("small.png", ia.Plane(small))
        run("grow a.png --map ao=small.png --crop 4,2,20,10 --method repeat --size 20x10 -q -o out.png")
        assert np.array_equal(pixels(Path("out.png")), pixels(Path("a.png"))[2:12, 4:24])
        assert np.array_equal(pixels(Path("out_ao.png")), small[1:6, 2:12])

    def test_stdin_and_stdout(self) -> None:
        result = run("grow", "-", "-o", "-", "--patch", 12, "-q", data=Path("a.png").read_bytes())
        loud = run("grow", "a.png", "-o", "-", "--patch", 12)
        run("grow", "a.png", "-o", "out.png", "--patch", 12, "-q")
        assert result.stdout_bytes == loud.stdout_bytes == Path("out.png").read_bytes()
        assert result.stderr == ""
        assert "seed 0" in loud.stderr

    def test_dry_run_writes_nothing(self) -> None:
        before = sorted(os.listdir())
        made = told(*GROW, "-o", "out.png", "--dry-run", "--overlap", 4)
        assert made["dry_run"]
        assert made["memory_mib"] > 0
        assert "not written" in run("grow a.png -o out.png --dry-run").stderr
        assert sorted(os.listdir()) == before

    def test_recipes_lie_beside_formats_without_text(self) -> None:
        run(*GROW, "-o", "out.bmp", "--seed", 3)
        assert json.loads(Path("out.bmp.recipe.json").read_text())["seed"] == 3
        run("replay", "out.bmp", "-e", "a.png", "-o", "again.bmp")
        run("replay", "out.bmp.recipe.json", "-e", "a.png", "-o", "third.bmp")
        assert Path("out.bmp").read_bytes() == Path("again.bmp").read_bytes() == Path("third.bmp").read_bytes()

    def test_the_seed_is_always_told(self) -> None:
        assert "seed 0" in run("grow", "a.png", "-o", "out.png").stderr
        made = told(*GROW, "--seed", "random", "-o", "out2.png")
        run(*GROW, "--seed", made["seed"], "-o", "out3.png")
        assert Path("out2.png").read_bytes() == Path("out3.png").read_bytes()

    def test_progress_bar_on_a_terminal(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("click.testing._NamedTextIOWrapper.isatty", lambda self: True)
        run("grow", "a.png", "-o", "out.png")
        assert Path("out.png").exists()


class TestSets:
    def test_files_that_share_a_stem_are_one_set(self) -> None:
        Path("a.png").rename("moss_albedo.png")
        Path("n.png").rename("moss_normal.png")
        result = run("grow", "moss_albedo.png", "moss_normal.png", "-o", "{stem}_big.png", "--patch", 12)
        assert "one set of 2 maps" in result.stderr
        assert Path("moss_big.png").exists()
        assert Path("moss_big_normal.png").exists()
        run("replay", "moss_big_normal.png", "-e", "moss_albedo.png", "-e", "moss_normal.png", "-o", "again.png", "-q")
        assert Path("again_normal.png").read_bytes() == Path("moss_big_normal.png").read_bytes()

    def test_several_exemplars_in_one_output(self) -> None:
        masks = "--mask mask.png --mask mask.png"
        assert len(told(f"grow a.png b.png -o out.png --patch 12 {masks}")["exemplars"]) == 2
        run(f"replay out.png -e a.png -e b.png {masks} -o two.png")
        assert Path("out.png").read_bytes() == Path("two.png").read_bytes()

    def test_set_and_several_force_the_reading(self) -> None:
        Path("a.png").rename("moss_albedo.png")
        Path("n.png").rename("other_normal.png")
        assert len(told("grow moss_albedo.png other_normal.png --set --dry-run -o o.png")["files"]) == 2
        Path("other_normal.png").rename("moss_ao.png")
        made = told("grow", "moss_albedo.png", "moss_ao.png", "--several", "--dry-run", "-o", "{stem}_o.png")
        assert len(made["results"]) == 2

    def test_batch_with_sheet(self) -> None:
        made = told("grow a.png b.png -m image-quilting --patch 12 --seeds 1..2 -o {stem}-{method}-{w}x{h}-{seed}.png "
                    "--sheet sheet.png --save-map {stem}{seed}.npz")  # fmt: skip
        expected = [(f"{stem}-image-quilting-96x80-{n}.png", n) for stem in "ab" for n in (1, 2)]
        assert [(r["files"][0]["path"], r["seed"]) for r in made["results"]] == expected
        sheet = pixels(Path("sheet.png"))
        assert sheet.shape == (2 * 80 + 3 * 8, 2 * 96 + 3 * 8, 3)
        assert np.array_equal(sheet[8:88, 8:104], pixels(Path("a-image-quilting-96x80-1.png")))
        assert made["sheet"] == "sheet.png"


class TestRender:
    def test_draws_what_was_grown_softer_in_part_and_with_other_planes(self) -> None:
        run(*GROW, "-o", "out.png", "--save-map", "m.npz", "--feather", 2, "--wrap", "x")
        run("render", "m.npz", "-e", "a.png", "-o", "again.png")
        whole = pixels(Path("out.png"))
        assert np.array_equal(pixels(Path("again.png")), whole)
        made = told("render", "m.npz", "-e", "a.png", "-o", "part.png", "--window", "-5,3,20,10")
        assert made["window"] == [-5, 3, 20, 10]
        assert np.array_equal(pixels(Path("part.png")), np.roll(whole, 5, axis=1)[3:13, :20])
        exact = "--feather", 0, "--even-tone", 0, "--threads", 1
        run("render", "m.npz", "-e", "b.png", "--map", "height=h.exr", "-o", "b2.png", *exact)
        smap = ia.SourceMap.load("m.npz")
        assert np.array_equal(pixels(Path("b2.png")), pixels(Path("b.png"))[smap.yx[:, :, 0], smap.yx[:, :, 1]])
        assert Path("b2_height.exr").exists()
        run("render", "m.npz", "-e", "a.png", "-o", "{stem}_{w}.png", "--mixing", "source", "--depth", "16")
        assert pixels(Path("a_64.png")).dtype == np.uint16

    def test_maps_of_samples_need_no_exemplar(self) -> None:
        run("grow", "sample:tiles", "-o", "out.png", "--size", 40, "--save-map", "m.npz", "-q")
        run("render", "m.npz", "-o", "again.png")
        run("replay", "out.png", "-o", "third.png")
        assert np.array_equal(pixels(Path("out.png")), pixels(Path("again.png")))
        assert Path("out.png").read_bytes() == Path("third.png").read_bytes()


class TestReplay:
    def test_another_version_is_a_warning(self) -> None:
        run(*GROW, "-o", "out.png")
        recipe = files.read_recipe("out.png")
        assert recipe is not None
        Path("old.json").write_text(json.dumps(recipe | {"intarsia": "0.0.1"}))
        result = run("replay", "old.json", "-e", "a.png", "-o", "again.png")
        assert "made by intarsia 0.0.1" in result.stderr
        assert np.array_equal(pixels(Path("out.png")), pixels(Path("again.png")))


def test_warm_up_grows_with_every_method() -> None:
    assert "ready: grew" in run("warm-up").stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_leaves_no_file(number: int) -> None:
    before = sorted(os.listdir())
    args = ["grow", "a.png", "-o", "out.png", "--size", "3000", "--patch", "9", "--progress", "json", "--threads", "1"]
    work = subprocess.Popen(
        [sys.executable, "-m", "intarsia", *args], stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # a shell's background jobs ignore Ctrl-C
    )  # fmt: skip
    assert work.stderr is not None
    while told := json.loads(work.stderr.readline() or "{}"):
        if 0 < told.get("fraction", 0) < 0.9:
            break
    sent = time.monotonic()
    work.send_signal(number)
    rest = work.stderr.read()
    assert work.wait(20) == 130
    assert time.monotonic() - sent < 2  # 0.2 s of work; the rest is for slow machines
    assert json.loads(rest.splitlines()[-1])["kind"] == "stopped"
    assert "Traceback" not in rest
    assert sorted(os.listdir()) == before
    work.stderr.close()


def test_a_closed_pipe_is_no_error_to_talk_about() -> None:
    work = subprocess.Popen(
        [sys.executable, "-m", "intarsia", "grow", "a.png", "-o", "-", "-q", "--size", "400", "--method", "repeat"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert work.stdout is not None
    assert work.stderr is not None
    work.stdout.close()
    assert work.stderr.read() == b""
    assert work.wait(20) == 1
    work.stderr.close()
