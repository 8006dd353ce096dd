"""Material sets: packed maps, maps that do not belong together, maps of other sizes, and layers of one file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli.commands import run, told
from files.exrs import save_exr
from numpy.typing import NDArray

import intarsia as ia
from intarsia import Kind, Plane, files
from intarsia.analysis.features import features
from intarsia.foundation import InputError, ParameterError
from intarsia.foundation.geometry import ISOMETRIES


def refused(line: str, code: int, words: str) -> None:
    """In one line that holds these words, with this exit code, and nothing is written."""
    before = sorted(os.listdir())
    said = [t for t in run(line, code=code).stderr.splitlines() if not t.startswith("exemplar ")]
    assert len(said) == 1
    assert all(word in said[0] for word in words.split()), said
    assert sorted(os.listdir()) == before


def pixels(path: str) -> NDArray[Any]:
    return files.read_plane(path).pixels


def noise(height: int = 40, width: int = 48, channels: int = 3, seed: int = 1, dtype: str = "uint8") -> NDArray[Any]:
    """Blobs of a few px: something to match."""
    coarse = np.random.default_rng(seed).integers(0, 256, (height // 4, width // 4, channels))
    return coarse.repeat(4, axis=0).repeat(4, axis=1).astype(dtype)


def put(name: str, array: NDArray[Any]) -> None:
    files.write(name, Plane(array[:, :, 0] if array.shape[2] == 1 else array))


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    put("w_albedo.png", noise())


PATCH = "--size 60x52 --method image-quilting --patch 12"


class TestPackedMaps:
    @pytest.mark.parametrize(("word", "names"), [
        ("ORM", "ao roughness metallic"), ("arm", "ao roughness metallic"), ("RMA", "roughness metallic ao"),
    ])  # fmt: skip
    def test_channels_are_planes_and_one_file_again(self, word: str, names: str) -> None:
        mixed = noise(seed=2)
        put(f"w_{word}.png", mixed)
        [found] = files.group(["w_albedo.png", f"w_{word}.png"])
        exemplar = files.read_set(found)
        assert list(exemplar.planes) == ["albedo", *names.split()]
        assert exemplar.pictures == ("albedo", word.lower())
        for channel, name in enumerate(names.split()):
            assert exemplar.planes[name].kind is Kind.DATA
            assert np.array_equal(exemplar.planes[name].pixels, mixed[:, :, channel])
        made = told(f"grow w_albedo.png w_{word}.png -o out.png {PATCH} --feather 0 --save-map m.npz -q")
        written = f"out_{word.lower()}.png"
        assert [f["path"] for f in made["files"]] == ["out.png", written, "m.npz"]
        yx = ia.SourceMap.load("m.npz").yx
        assert np.array_equal(pixels(written), mixed[yx[..., 0], yx[..., 1]])  # bit for bit
        assert np.array_equal(pixels("out.png"), noise()[yx[..., 0], yx[..., 1]])

    def test_drawn_alone_or_together_they_agree(self) -> None:
        e = ia.Exemplar.of({"albedo": noise(), "orm": noise(seed=2, dtype="uint16") * 257})
        for feather in (0, 4):
            made = ia.synthesize(e, (50, 60), ia.ImageQuilting(patch=12), blend=ia.Blend(feather))
            together = made.render("orm").pixels
            alone = [made.render(name).pixels for name in ("ao", "roughness", "metallic")]
            assert together.dtype == np.uint16
            assert np.array_equal(together, np.dstack(alone))
        with pytest.raises(ParameterError, match="albedo, ao, roughness, metallic, orm"):
            made.render("rma")

    def test_each_channel_counts_by_its_own_range(self) -> None:
        """Faint metal is compared as well as strong occlusion: as by planes in files of their own."""
        mixed = noise(seed=2)
        mixed[:, :, 2] //= 32
        packed = ia.Exemplar.of({"albedo": noise(), "orm": mixed})
        names = ("ao", "roughness", "metallic")
        alone = ia.Exemplar.of({"albedo": noise()} | {n: mixed[:, :, c] for c, n in enumerate(names)})
        one, two = (ia.synthesize(e, (50, 60), ia.ImageQuilting(patch=12)).map.yx for e in (packed, alone))
        assert np.array_equal(one, two)

    def test_channels_are_told(self) -> None:
        mixed = noise(channels=4, seed=3)
        put("mix.png", mixed)
        line = f"grow w_albedo.png --map packed=mix.png --packed R=metallic,A=roughness {PATCH} --feather 0"
        run(f"{line} -o out.png --save-map m.npz")
        yx = ia.SourceMap.load("m.npz").yx
        assert np.array_equal(pixels("out_packed.png"), mixed[yx[..., 0], yx[..., 1]])
        exemplar = ia.read("w_albedo.png", packed="mix.png", channels="R=metallic, A=roughness")
        assert list(exemplar.planes) == ["albedo", "metallic", "packed_g", "packed_b", "roughness"]
        run("replay out_packed.png -e w_albedo.png --map packed=mix.png -o again.png")
        assert Path("again_packed.png").read_bytes() == Path("out_packed.png").read_bytes()
        run("replay out.png -e w_albedo.png --map packed=mix.png --packed R=ao -o no.png", code=3)
        auto = told("grow w_albedo.png --map packed=mix.png --packed R=metallic,A=roughness --dry-run -o o.png")
        assert "--packed R=metallic,A=roughness" in auto["auto"]["command"]

    def test_a_packed_map_alone_is_one_picture(self) -> None:
        put("w_orm.png", noise(seed=2))
        assert told(f"grow w_orm.png -o out.png {PATCH} -q")["files"] == [{"path": "out.png", "holds": "orm"}]
        assert pixels("out.png").shape == (52, 60, 3)
        assert told(f"grow w_orm.png {PATCH} --magnify 2 --patch 6 -q")["files"][0]["path"] == "w_orm_grown.png"

    def test_all_that_handles_planes_handles_packed_ones(self) -> None:
        put("w_orm.png", noise(seed=2))
        put("hole.png", np.pad(np.full((9, 9, 1), 255, np.uint8), ((9, 22), (9, 30), (0, 0))))
        both = "--map orm=w_orm.png"
        run(f"heal w_albedo.png {both} --mask hole.png --patch 6 -o healed.png")
        run(f"extend w_albedo.png {both} --right 9 -o longer.png --patch 9")
        run(f"weave w_albedo.png {both} --size 64x48 --method repeat -o woven.tif")
        run(f"grow w_albedo.png {both} {PATCH} -o out.png --save-map m.npz --scale 1/2")
        run(f"render m.npz -e w_albedo.png {both} --scale 1/2 -o drawn.png")
        assert np.array_equal(pixels("drawn_orm.png"), pixels("out_orm.png"))
        healed = pixels("healed_orm.png")
        outside = pixels("hole.png") == 0
        assert np.array_equal(healed[outside], noise(seed=2)[outside])
        assert pixels("longer_orm.png").shape == (40, 57, 3)
        assert np.array_equal(pixels("woven_orm.tif")[:40, :48], noise(seed=2))

    @pytest.mark.parametrize(("line", "code", "words"), [
        ("w_albedo.png w_orm.png w_ao.png", 3, "w_orm.png w_ao.png both ao"),
        ("w_albedo.png --map orm=w_ao.png", 3, "w_ao.png 1 channels"),
        ("w_albedo.png --map packed=w_orm.png", 2, "w_orm.png --packed"),
        ("w_albedo.png --packed R=ao", 2, "none w_albedo.png"),
        ("w_albedo.png --map orm=w_orm.png --map rma=w_rma.png --packed R=ao", 2, "several w_orm.png w_rma.png"),
        ("w_albedo.png --map orm=w_orm.png --packed R=ao,G=ao", 2, "at most one"),
        ("w_albedo.png --map orm=w_orm.png --packed R=albedo", 2, "ao, roughness"),
        ("w_albedo.png --map orm=w_orm.png --packed ao", 2, "R=ao,G=roughness,B=metallic"),
        ("w_albedo.png --map orm=w_orm.png --packed R=ao,A=height", 3, "3 channels w_orm.png"),
    ])  # fmt: skip
    def test_what_cannot_be_packed_is_refused(self, line: str, code: int, words: str) -> None:
        for name, channels in (("orm", 3), ("rma", 3), ("ao", 1)):
            put(f"w_{name}.png", noise(channels=channels))
        refused(f"grow {line} -o out.png", code, words)
        with pytest.raises(InputError, match="orm holds ao"):
            ia.Exemplar.of({"albedo": noise(), "ao": noise(channels=1), "orm": noise()})



def slopes(height: int = 40, width: int = 48) -> NDArray[Any]:
    """The codes of a normal map that is one."""
    y, x = np.mgrid[:height, :width] / 6.0
    n = np.dstack([np.sin(x) / 2, np.cos(y + x) / 2, np.ones((height, width))])
    n /= np.sqrt((n * n).sum(axis=2))[..., None]
    return np.asarray(np.floor((n + 1) * 127.5 + 0.5), np.uint8)


class TestBadSets:
    @pytest.mark.parametrize(("given", "words"), [
        ("w_albedo.png w_height.png w_disp.png", "w_height.png w_disp.png both are the height"),
        ("w_normal.png w_height.png", "w_normal.png w_height.png without the picture"),
        ("w_albedo.png w_ao.png", "w_ao.png (ao) 48x30 another shape w_albedo.png (48x40)"),
        ("w_albedo.png w_rough.png", "w_rough.png (roughness) 72x60 w_albedo.png 48x40 whole multiple"),
        ("w_albedo.png w_orm.png", "w_orm.png (orm) 40x48 another shape w_albedo.png"),
        ("w_albedo.png --map height=none.png", "none.png does not exist"),
    ])  # fmt: skip
    def test_are_refused_in_one_line_that_names_the_files(self, given: str, words: str) -> None:
        for name, size in (("height", (40, 48, 1)), ("disp", (40, 48, 1)), ("ao", (30, 48, 1)), ("rough", (60, 72, 1)),
                           ("orm", (48, 40, 3))):  # fmt: skip
            put(f"w_{name}.png", np.zeros(size, np.uint8))
        put("w_normal.png", slopes())
        for command in ("grow", "weave --size 32 --method repeat"):
            refused(f"{command} {given} -o out.tif", 3, words)

    def test_one_map_alone_needs_no_base(self) -> None:
        put("w_normal.png", slopes())
        put("w_height.png", noise(channels=1))
        made = told(f"grow w_normal.png --map height=w_height.png -o out.png {PATCH} -q")
        assert [f["holds"] for f in made["files"]] == ["normal", "height"]

    def test_a_picture_as_normal_map_is_told(self) -> None:
        put("w_normal.png", slopes())
        assert told("grow w_albedo.png w_normal.png --dry-run -q")["warnings"] == []
        put("photo.png", noise() // 4 + 60)
        for line in ("grow w_albedo.png --dry-run", "grow w_albedo.png -o b.png --method repeat"):
            [warning] = told(f"{line} --map normal=photo.png -q")["warnings"]
            assert "photo.png" in warning
            assert "off length 1" in warning

    @pytest.mark.parametrize("force", ["", "--force"])
    def test_all_maps_are_written_or_none(self, force: str, monkeypatch: pytest.MonkeyPatch) -> None:
        """Whichever file of a set cannot be made, the places stay as they were."""
        put("w_normal.png", slopes())
        put("w_orm.png", noise(seed=2))
        line = f"grow w_albedo.png w_normal.png w_orm.png -o out.png {PATCH}"
        if force:
            for name in ("out.png", "out_normal.png", "out_orm.png"):
                Path(name).write_bytes(b"old")
        before = {p: p.read_bytes() for p in Path().iterdir()}
        from intarsia.cli import batch

        for last in range(3):
            left = iter(range(last))

            def failing(*given: Any, left: Any = left, **more: Any) -> None:
                if next(left, None) is None:
                    raise ia.ResourceError("the disk is full.")
                files.write(*given, **more)

            monkeypatch.setattr(batch, "write", failing)
            run(f"{line} {force}", code=1)
            assert {p: p.read_bytes() for p in Path().iterdir()} == before


class TestWeights:
    def set_of_two(self, **weights: float) -> ia.Exemplar:
        height = noise(channels=1, seed=5)
        return ia.Exemplar.of({"albedo": noise(), "height": height[:, :, 0]}, weights=weights)

    def test_a_plane_counts_as_much_as_it_is_said_to(self) -> None:
        """Distances are the sum of those of the planes, each times its weight."""
        usual = features([self.set_of_two()]).pictures[0].astype(float)
        for weights, scale in (({"height": 0.25}, [1, 1, 1, 0.5]), ({"albedo": 0.25}, [0.5, 0.5, 0.5, 1]),
                               ({"albedo": 4, "height": 16}, [0.5, 0.5, 0.5, 1]),
                               ({"height": 4}, [0.5, 0.5, 0.5, 1])):  # fmt: skip
            picture = features([self.set_of_two(**weights)]).pictures[0]
            assert np.abs(picture).max() <= np.abs(usual).max()
            assert np.abs(picture - usual * scale).max() <= 1
        assert features([self.set_of_two(height=0)]).pictures[0].shape[2] == 3
        assert not features([self.set_of_two(albedo=0)]).pictures[0][:, :, :3].any()

    def test_one_changes_nothing(self) -> None:
        assert self.set_of_two(albedo=1, height=1.0).digest == self.set_of_two().digest
        assert self.set_of_two(height=0.5).digest != self.set_of_two().digest

    def test_a_plane_of_weight_0_is_drawn_only(self) -> None:
        """The map is that of the others alone."""
        method = ia.ImageQuilting(patch=12)
        made = ia.synthesize(self.set_of_two(height=0), (50, 60), method)
        alone = ia.synthesize(noise(), (50, 60), method)
        assert np.array_equal(made.map.yx, alone.map.yx)
        assert made.render("height").pixels.shape == (50, 60)
        other = ia.synthesize(self.set_of_two(albedo=0), (50, 60), method)
        height = ia.synthesize(noise(channels=1, seed=5), (50, 60), method)
        assert not np.array_equal(other.map.yx, alone.map.yx)
        seam = [np.abs(np.diff(m.render(n).pixels.astype(float), axis=1)).mean()
                for m, n in ((other, "height"), (made, "height"), (height, None))]  # fmt: skip
        assert seam[0] < seam[1]

    def test_the_command_line_says_it_and_replay_makes_the_same(self) -> None:
        put("w_height.png", noise(channels=1, seed=5))
        put("w_orm.png", noise(seed=6))
        line = f"grow w_albedo.png w_height.png w_orm.png {PATCH} --seed 3"
        run(f"{line} -o usual.png")
        run(f"{line} -o out.png --weight height=0.5 --weight orm=0 --magnify 2 --patch 6")
        recipe = files.read_recipe("out_height.png")
        assert recipe is not None
        assert recipe["inputs"]["weights"] == {"height": 0.5, "orm": 0.0}
        assert recipe["exemplars"][0]["weights"] == {"height": 0.5, "ao": 0, "roughness": 0, "metallic": 0}
        run("replay out.png -e w_albedo.png -e w_height.png -e w_orm.png -o again.png")
        for name in ("", "_height", "_orm"):
            assert Path(f"again{name}.png").read_bytes() == Path(f"out{name}.png").read_bytes()
        run("replay out.png -e w_albedo.png -e w_height.png -e w_orm.png -o no.png --weight height=0.4", code=3)
        assert "weights" not in (files.read_recipe("usual.png") or {})["exemplars"][0]
        run(f"{line} -o one.png --weight height=1")
        assert np.array_equal(pixels("one.png"), pixels("usual.png"))
        told_again = told("grow w_albedo.png w_height.png --weight height=0.125 --dry-run")["auto"]["command"]
        assert "--plane-weight height=0.125" in told_again

    @pytest.mark.parametrize(("weights", "words"), [
        ("--weight depth=1", "no such plane albedo, height"), ("--weight height=-1", "0 to 100"),
        ("--weight height=nan", "0 to 100"), ("--weight height", "height=0.5"), ("--weight =1", "NAME=F"),
        ("--weight height=0 --weight albedo=0", "to compare"),
    ])  # fmt: skip
    def test_weights_that_say_nothing_are_refused(self, weights: str, words: str) -> None:
        put("w_height.png", noise(channels=1, seed=5))
        refused(f"grow w_albedo.png w_height.png {weights} -o out.png", 2, words)

    def test_numbers_only(self) -> None:
        for wrong in ("1", True, None, float("nan"), 101):
            with pytest.raises(ParameterError, match="0 to 100"):
                ia.Exemplar.of({"albedo": noise()}, weights={"albedo": wrong})  # type: ignore[dict-item]


class TestOtherSizes:
    """Maps of half and a quarter, twice and four times the size of the first, drawn from the same map."""

    SIZES = (("ao", 0.5), ("metallic", 0.25), ("roughness", 2), ("height", 4), ("normal", 2))

    def planes(self) -> dict[str, NDArray[Any]]:
        """Each pixel says where it lies, at its own scale; normals are those of a relief."""
        out: dict[str, NDArray[Any]] = {"albedo": noise()}
        for name, times in self.SIZES:
            h, w = int(40 * times), int(48 * times)
            out[name] = slopes(h, w) if name == "normal" else np.arange(h * w, dtype=np.uint16).reshape(h, w)
        return out

    @pytest.mark.parametrize("poses", [(0,), tuple(range(8))])
    def test_are_aligned_to_the_pixel(self, poses: tuple[int, ...]) -> None:
        """A pixel of a larger plane lies where the map says, turned about the middle of its px; found one by one."""
        given = self.planes()
        method = ia.ImageQuilting(patch=12, isometries=poses)
        made = ia.synthesize(ia.Exemplar.of(given), (52, 60), method, blend=ia.Blend(0))
        yx, pose = made.map.yx, made.map.turns
        assert set(np.unique(pose)) == set(poses)
        for name, times in self.SIZES:
            drawn = made.render(name).pixels
            assert drawn.shape[:2] == (52 * times, 60 * times)
            if times < 1 or name == "normal":
                continue
            s = int(times)
            for y, x in np.random.default_rng(1).integers(0, 52 * s, (300, 2)):
                (a, b), (c, d) = ISOMETRIES[pose[y // s, x // s]].j
                v, u = 2 * (y % s) + 1 - s, 2 * (x % s) + 1 - s  # from the middle, in half px
                row, column = ((n + s - 1) // 2 for n in (a * v + b * u, c * v + d * u))
                at = yx[y // s, x // s] * s
                assert drawn[y, x] == given[name][at[0] + row, at[1] + column]

    def test_blocks_that_are_copied_whole_are_copied_exactly(self) -> None:
        given = self.planes()
        made = ia.synthesize(ia.Exemplar.of(given), (80, 96), "repeat", blend=ia.Blend(0))
        for name, times in self.SIZES:
            h, w = int(40 * times), int(48 * times)
            assert np.array_equal(made.render(name).pixels[:h, :w], given[name])
            assert np.array_equal(made.render(name).pixels[h:, w:], given[name])

    def test_a_window_is_cut_out_of_the_whole(self) -> None:
        made = ia.synthesize(ia.Exemplar.of(self.planes()), (52, 60), ia.ImageQuilting(patch=12), blend=ia.Blend(4))
        for name, times in self.SIZES:
            part = made.render(name, box=ia.Box(8, 12, 40, 44)).pixels
            rows, columns = (slice(int(a * times), int(b * times)) for a, b in ((8, 40), (12, 44)))
            assert np.array_equal(part, made.render(name).pixels[rows, columns])

    def test_larger_normals_turn_with_their_pieces(self) -> None:
        """At twice the size they are those of the relief that the larger height tells, as at its own."""
        given = {"albedo": noise(), "normal": slopes()}
        doubled = {"albedo": noise(), "normal": slopes().repeat(2, axis=0).repeat(2, axis=1)}
        method = ia.ImageQuilting(patch=12, isometries=tuple(range(8)))
        one, two = (ia.synthesize(ia.Exemplar.of(g), 60, method, blend=ia.Blend(0)) for g in (given, doubled))
        assert np.array_equal(one.map.yx, two.map.yx)
        assert np.array_equal(one.render("normal").pixels.repeat(2, 0).repeat(2, 1), two.render("normal").pixels)

    @pytest.mark.parametrize(("line", "words"), [
        ("grow w_albedo.png w_ao.png --size 61x52", "61x52 plane ao 2x smaller multiples of 2"),
        ("extend w_albedo.png --map ao=w_ao.png --right 9", "57x40 plane ao multiples of 2"),
        ("weave w_albedo.png w_ao.png --size 61x52 --method repeat", "61x52 plane ao multiples of 2"),
        ("grow w_albedo.png w_rough.png --size 60 --feather 600", "feather=600 plane roughness 4x larger 500"),
        ("render m.npz -e w_albedo.png -e w_ao.png --window 1,1,9,9", "9x9 plane ao multiples of 2"),
    ])  # fmt: skip
    def test_what_does_not_suit_them_is_refused_before_work(
        self, line: str, words: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        put("w_ao.png", noise(20, 24, 1))
        put("w_rough.png", noise(160, 192, 1))
        ia.synthesize(noise(), (52, 60), ia.ImageQuilting(patch=12)).map.save("m.npz")
        from intarsia.cli import batch

        monkeypatch.setattr(batch, "made_of", None)  # what grows
        refused(f"{line} -o out.tif", 2, words)


class TestLayers:
    def floats(self, seed: int = 1, count: int = 1) -> list[NDArray[Any]]:
        return [a.astype(np.float32) / 255 for a in np.moveaxis(noise(channels=count, seed=seed), 2, 0)]

    def layered(self, path: str = "moss.exr") -> dict[str, NDArray[Any]]:
        """Layers as renderers write them: channels sorted by name, deep names, and some that are no maps."""
        r, g, b, h, o = self.floats(2, 5)
        n = slopes().astype(np.float32) / 127.5 - 1
        channels = {
            "View.diffuse.B": b, "View.diffuse.G": g, "View.diffuse.R": r, "Z": h, "height": h, "normal.X": n[..., 0],
            "normal.Y": n[..., 1], "normal.Z": n[..., 2], "roughness.Y": o, "time.Y": h,
        }  # fmt: skip
        save_exr(path, channels, ("half", "half", "half", "float", "float", *["float"] * 3, "half", "float"))
        return channels

    def test_an_exr_file_is_read_as_a_set(self) -> None:
        channels = self.layered()
        moss = ia.read("moss.exr")
        assert list(moss.planes) == ["albedo", "normal", "roughness", "height"]
        assert moss.name == "moss"
        for name, plane in moss.planes.items():
            own = {"albedo": ["View.diffuse.R", "View.diffuse.G", "View.diffuse.B"], "height": ["height"],
                   "normal": ["normal.X", "normal.Y", "normal.Z"], "roughness": ["roughness.Y"]}[name]  # fmt: skip
            wanted = np.dstack([channels[c] for c in own]).astype(plane.pixels.dtype)
            assert np.array_equal(plane.samples, wanted)
        assert moss.planes["albedo"].pixels.dtype == moss.planes["roughness"].pixels.dtype == np.float16
        assert moss.planes["height"].kind is Kind.DATA
        assert moss.planes["height"].pixels.dtype == np.float32
        assert moss.planes["normal"].kind is Kind.NORMAL
        assert np.array_equal(files.read_plane("moss.exr::time").pixels, channels["time.Y"])
        assert files.group(["moss.exr"])[0]["normal"] == "moss.exr::normal"

    def test_a_set_goes_in_as_one_file_and_comes_out_plane_by_plane(self) -> None:
        self.layered()
        made = told(f"grow moss.exr -o out.exr {PATCH} --feather 0 --seed 2 --save-map m.npz -q")["files"]
        assert [f["path"] for f in made[:4]] == ["out.exr", "out_normal.exr", "out_roughness.exr", "out_height.exr"]
        once, yx = ia.read("moss.exr"), ia.SourceMap.load("m.npz").yx
        for file in made[:4]:
            drawn, plane = files.read_plane(file["path"]), once.planes[file["holds"]]
            assert drawn.pixels.dtype == plane.pixels.dtype
            assert np.array_equal(drawn.pixels, plane.pixels[yx[..., 0], yx[..., 1]])  # bit for bit

    def test_the_library_writes_layers(self) -> None:
        rgba = np.dstack(self.floats(4, 4)).astype(np.float16)
        rgba[..., 3] = rgba[..., 3] > 0.5
        seven = np.dstack(self.floats(5, 7))
        files.write("x.exr", {"albedo": rgba, "spectrum": seven, "height": seven[..., 0]}, recipe="{}")
        assert np.array_equal(files.read_plane("x.exr::albedo").pixels, rgba)
        assert np.array_equal(files.read_plane("x.exr::spectrum").pixels, seven)
        assert list(ia.read("x.exr", alpha="channel").planes) == ["albedo", "height"]
        assert files.read_recipe("x.exr") == {}
        files.write("y.exr", {"albedo": rgba, "spectrum": seven, "height": seven[..., 0]}, recipe="{}")
        assert Path("x.exr").read_bytes() == Path("y.exr").read_bytes()
        with pytest.raises(ParameterError, match="exists"):
            files.write("x.exr", {"albedo": rgba})
        with pytest.raises(ParameterError, match="at least one"):
            files.write("z.exr", {})

    def test_a_picture_without_a_name_is_the_albedo(self) -> None:
        r, g, b, h = self.floats(2, 4)
        save_exr("a.exr", {"B": b, "G": g, "R": r, "bump.Y": h})
        assert list(ia.read("a.exr").planes) == ["albedo", "height"]
        save_exr("b.exr", {"B": b, "G": g, "R": r, "Z": h})
        assert list(ia.read("b.exr").planes) == ["albedo"]
        assert ia.read("b.exr").base.channels == 3

    @pytest.mark.parametrize(("line", "code", "words"), [
        ("grow twice.exr -o out.png", 3, "twice.exr bump.Y height disp"),
        ("grow bare.exr -o out.png", 3, "bare.exr height roughness without"),
        ("grow w_albedo.png --map height=moss.exr::depth -o out.png", 3, "moss.exr::depth height normal"),
        ("grow w_albedo.png --map height=plain.exr::normal -o out.png", 3, "plain.exr::normal png"),
    ])  # fmt: skip
    def test_what_are_no_layers_is_refused(self, line: str, code: int, words: str) -> None:
        self.layered()
        put("w_ao.png", noise(20, 24, 1))
        Path("plain.exr").write_bytes(Path("w_albedo.png").read_bytes())
        r, g, b, h = self.floats(2, 4)
        save_exr("twice.exr", {"R": r, "G": g, "B": b, "bump.Y": h, "disp.Y": h})
        save_exr("bare.exr", {"height.Y": h, "roughness.Y": r})
        words = words.replace("bump.Y height disp", "bump disp both are the height")
        refused(line, code, words)
