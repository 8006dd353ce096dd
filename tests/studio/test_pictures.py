"""What the studio draws, against what the library knows."""

from __future__ import annotations

import io
import time
import zipfile
from typing import Any

import numpy as np
import pytest
from studio.served import QUICK, Served, opened, pixels, png

import intarsia as ia
from intarsia import files
from intarsia.request import fields_of_verb
from intarsia.studio import requests


@pytest.fixture(scope="module")
def result(served: Served, small: str) -> Any:
    """A result with many pieces."""
    return served.done("grow", [small], **QUICK, seed=6)


@pytest.fixture(scope="module")
def smap(served: Served, result: Any, tmp_path_factory: pytest.TempPathFactory) -> ia.SourceMap:
    """Its map."""
    path = tmp_path_factory.mktemp("map") / "map.npz"
    path.write_bytes(served.files(result)["map.npz"])
    return ia.SourceMap.load(str(path))


def seen(served: Served, result: Any, kind: str, side: int = 64) -> np.ndarray:
    return opened(served.bytes(f"/api/results/{result['id']}/view/{kind}.png?side={side}"))


def nothing_is_left(served: Served) -> bool:
    """Whether no folder in the making stays; one goes a moment after its answer."""
    for _ in range(100):
        if not list((served.folder / "results").glob(".under-way-*")):
            return True
        time.sleep(0.05)
    return False


class TestResults:
    def test_the_map_for_hovering_is_the_map(self, served: Served, result: Any, smap: ia.SourceMap) -> None:
        data = np.frombuffer(served.bytes(f"/api/results/{result['id']}/map.bin"), "<u2").reshape(40, 48, 3)
        assert np.array_equal(data[..., 1:], smap.yx)
        assert (data[..., 0] == 0).all()
        assert np.array_equal(pixels()[data[..., 1], data[..., 2]], seen(served, result, "albedo"))

    def test_pieces_have_one_colour_each_and_a_border(
        self, served: Served, result: Any, smap: ia.SourceMap
    ) -> None:
        drawn, numbers = seen(served, result, "pieces"), smap.pieces()
        inside = np.ones(numbers.shape, bool)
        inside[:-1] &= numbers[:-1] == numbers[1:]
        inside[:, :-1] &= numbers[:, :-1] == numbers[:, 1:]
        for number in np.unique(numbers):
            colours = drawn[(numbers == number) & inside]
            assert len(np.unique(colours, axis=0)) <= 1
        beside = inside[:, :-1] & ~inside[:, 1:] & (numbers[:, :-1] == numbers[:, 1:])
        assert (drawn[:, 1:, :3][beside].sum(axis=1) < drawn[:, :-1, :3][beside].sum(axis=1)).all()

    def test_provenance_tells_the_place_by_colour(self, served: Served, result: Any, smap: ia.SourceMap) -> None:
        drawn = seen(served, result, "provenance").astype(int)
        for axis, channel, length in ((1, 0, 36), (0, 1, 32)):
            at = smap.yx[..., axis]
            assert np.abs(drawn[..., channel] - (40 + 200 * at / (length - 1))).max() <= 1

    def test_what_is_shown_more_is_brighter(self, served: Served, result: Any, smap: ia.SourceMap) -> None:
        drawn = seen(served, result, "usage").astype(int)[..., :3].sum(axis=2)
        count = smap.usage()[0][smap.yx[..., 0], smap.yx[..., 1]]
        assert np.corrcoef(drawn.ravel(), count.ravel())[0, 1] > 0.2

    def test_what_judging_found_is_laid_over(self, served: Served) -> None:
        exemplar = served.exemplar(field=png(pixels(80, 80)))["id"]
        made = served.done("grow", [exemplar], **QUICK | {"size": "120x110", "patch": "20"}, crop="0,0,72,70")
        drawn = seen(served, made, "seams", side=200)
        assert drawn.shape == (110, 120, 4)
        assert (drawn[..., 3] == 0).any()

    def test_a_view_is_no_larger_than_asked(self, served: Served, result: Any) -> None:
        for kind in ("albedo", "pieces", "usage", "provenance"):
            assert max(seen(served, result, kind, side=20).shape[:2]) <= 24

    def test_a_part_is_those_pixels(self, served: Served, result: Any, smap: ia.SourceMap) -> None:
        address = f"/api/results/{result['id']}"
        whole = seen(served, result, "albedo")
        part = opened(served.bytes(f"{address}/view/albedo.png?box=20,10,16,8"))
        assert np.array_equal(part, whole[10:18, 20:36])
        answer = served.client.get(f"{address}/map.bin?box=20,10,16,8")
        came = np.frombuffer(answer.content, "<u2").reshape(8, 16, 3)
        assert np.array_equal(came[..., 1:], smap.yx[10:18, 20:36])
        assert answer.headers["x-size"] == "48x40"
        exemplar = f"/api/exemplars/{result['exemplars'][0]}/albedo.png?box=3,5,7,6"
        assert np.array_equal(opened(served.bytes(exemplar)), pixels()[5:11, 3:10])
        for box in ("1,2,3", "1,2,0,4", "-1,2,3,4", "1,2,3,4097", "48,0,4,4"):
            refused = served.client.get(f"{address}/view/albedo.png?box={box}")
            assert (refused.status_code, refused.json()["error"][:4]) == (400, "box:")

    def test_an_archive_holds_all_files_and_leaves_none(self, served: Served, result: Any) -> None:
        answer = served.client.get(f"/api/results/{result['id']}/all.zip")
        assert answer.headers["content-disposition"] == 'attachment; filename="small_grown_image-quilting_s6.zip"'
        archive = zipfile.ZipFile(io.BytesIO(answer.content))
        found = {name: archive.read(name) for name in archive.namelist()}
        assert found.pop("command.txt").decode() == result["command"] + "\n"
        assert found.pop("small.png") == png(pixels())
        assert found == {f"made/{name}": data for name, data in served.files(result).items()}
        assert nothing_is_left(served)

    def test_a_report_is_that_of_the_command_and_names_no_folder(self, served: Served, result: Any) -> None:
        answer = served.client.get(f"/api/results/{result['id']}/report.html")
        assert answer.headers["content-disposition"] == 'attachment; filename="small_grown_report.html"'
        page = answer.text
        total = served.get(f"/api/results/{result['id']}")["score"]["total"]
        assert f"{total:.0f}" in page
        assert "small_grown.png" in page
        assert "Its recipe" in page
        assert "exemplars/" not in page
        assert str(served.folder) not in page
        assert nothing_is_left(served)

    def test_places_lie_in_the_picture(self, served: Served, result: Any) -> None:
        places = served.get(f"/api/results/{result['id']}/places")
        assert set(places) == {"joins", "overused", "salient", "repeats"}
        assert all(0 <= x < 48 and 0 <= y < 40 and side == 48 for name in places for x, y, side in places[name])

    def test_what_was_mended_is_scored_against_the_first_exemplar(self, served: Served, small: str) -> None:
        made = served.done("grow", [small], **QUICK)
        onward = served.post("/api/exemplars", {"result": made["id"]}, 201)["id"]
        hole = np.zeros((40, 48), np.uint8)
        hole[10:20, 10:20] = 255
        mended = served.done("heal", [onward], mask=[served.image(hole)], method="image-quilting", patch="8")
        assert [word for word in mended["score_words"] if "exemplars" in word] == [
            word for word in made["score_words"] if "exemplars" in word
        ]
        assert not [word for word in mended["score_words"] if word.startswith("--map")]
        assert mended["pictures"][0] in mended["score_words"]
        assert served.client.get(f"/api/results/{mended['id']}/places").status_code == 200

    def test_what_is_not_judged_has_no_report(self, served: Served, small: str, result: Any) -> None:
        made = served.done("render", [small], map=result["id"], feather=2)
        answer = served.client.get(f"/api/results/{made['id']}/report.html")
        assert (answer.status_code, answer.json()["error"]) == (400, "this result cannot be judged.")

    def test_a_result_becomes_an_exemplar(self, served: Served, result: Any) -> None:
        row = served.post("/api/exemplars", {"result": result["id"]})
        assert (row["name"], row["width"], row["height"]) == ("small_grown", 48, 40)
        view = opened(served.plane(row))
        assert np.array_equal(view, seen(served, result, "albedo"))

    def test_a_map_is_drawn_again_softer(self, served: Served, small: str, result: Any) -> None:
        made = served.done("render", [small], map=result["id"], feather=3)
        drawn = opened(next(iter(served.files(made).values())))
        assert drawn.shape == (40, 48, 3)
        assert not np.array_equal(drawn, seen(served, result, "albedo"))


class TestExemplars:
    def test_what_was_found_is_what_analyze_tells(self, served: Served) -> None:
        row = served.post("/api/exemplars", {"sample": "tiles"})
        found = served.get(f"/api/exemplars/{row['id']}/found")
        analyzed = ia.analyze("sample:tiles")
        known = analyzed.as_dict()
        for key in ("lattice", "feature_size", "elements", "suggested", "light"):
            assert found[key] == known[key]
        assert "lattice" in found["overlays"]
        picture = opened(served.bytes(f"/api/exemplars/{row['id']}/albedo.png?side=4096"))[..., :3]
        for kind in found["overlays"]:
            drawn = opened(served.bytes(f"/api/exemplars/{row['id']}/found/{kind}.png"))
            assert drawn.shape == (row["height"], row["width"], 4)
            assert (drawn[..., 3] > 0).any()
            assert (drawn[..., 3] == 0).any() or kind == "segments"
        drawn = opened(served.bytes(f"/api/exemplars/{row['id']}/found/lattice.png"))
        whole = np.where(drawn[..., 3:] > 0, drawn[..., :3], picture)
        assert np.array_equal(whole, analyzed.overlay().pixels)

    def test_what_was_not_found_is_refused(self, served: Served, small: str) -> None:
        kinds = {"lattice", "courses", "elements", "striking", "segments", "nonsense"}
        missing = kinds - set(served.get(f"/api/exemplars/{small}/found")["overlays"])
        assert missing
        for kind in missing:
            assert served.client.get(f"/api/exemplars/{small}/found/{kind}.png").status_code == 400

    @pytest.mark.parametrize("count", [2, 5])
    def test_so_many_labels_are_proposed_as_are_asked_for(self, served: Served, small: str, count: int) -> None:
        found = opened(served.bytes(f"/api/exemplars/{small}/labels/{count}.png"))
        areas = np.bincount(found.ravel())
        assert found.shape == pixels().shape[:2]
        assert len(areas) == count
        assert areas.min() > 0
        assert areas[0] == areas.max()

    @pytest.mark.parametrize("count", [-1, 1, 7, 10**9])
    def test_other_numbers_of_labels_are_refused(self, served: Served, small: str, count: int) -> None:
        answer = served.client.get(f"/api/exemplars/{small}/labels/{count}.png")
        assert answer.status_code == 400
        assert answer.json()["error"] == f"{count} labels cannot be proposed; ask for 2 to 6."


    def test_cut_and_flattened(self, served: Served, small: str) -> None:
        row = served.post(f"/api/exemplars/{small}/edit", {"crop": [4, 2, 20, 16]}, 201)
        assert row["name"] == "small_cropped"
        assert np.array_equal(opened(served.plane(row)), pixels()[2:18, 4:24])
        flat = served.post(f"/api/exemplars/{small}/edit", {"flatten": True}, 201)
        known = files.preview(ia.flattened(ia.Exemplar.of(pixels())).base).pixels
        assert np.array_equal(opened(served.plane(flat)), known)

    def test_straightened_courses_come_with_a_mask(self, served: Served) -> None:
        row = served.post("/api/exemplars", {"sample": "brick"})
        straight = served.post(f"/api/exemplars/{row['id']}/edit", {"straighten": True}, 201)
        assert [plane["name"] for plane in straight["planes"]] == ["albedo", "mask"]
        assert set(np.unique(opened(served.plane(straight, 1)))) == {0, 255}

    @pytest.mark.parametrize(
        "given", [{}, {"crop": [0, 0, 99, 99]}, {"crop": "0,0,5"}, {"crop": [1, 2]}, {"flatten": 1}, {"x": 1},
                  {"straighten": True}, {"crop": [0, 0, 0, 5]}, {"crop": [True, 0, 5, 5]}]
    )  # fmt: skip
    def test_edits_that_cannot_be_are_refused(self, served: Served, small: str, given: Any) -> None:
        before = len(served.get("/api/exemplars"))
        answer = served.client.post(f"/api/exemplars/{small}/edit", json=given)
        assert answer.status_code == 400
        assert str(served.folder) not in answer.text
        assert len(served.get("/api/exemplars")) == before

    def test_a_set_is_one_exemplar_and_two_are_two(self, served: Served) -> None:
        row = served.exemplar(moss_albedo=png(pixels()), moss_height=png(pixels()[..., 0]))
        assert [plane["name"] for plane in row["planes"]] == ["albedo", "height"]
        parts = [("files", (name, png(pixels()))) for name in ("a.png", "b.png")]
        answer = served.client.post("/api/exemplars", files=parts)
        assert (answer.status_code, answer.json()["name"], answer.json()["opened"]) == (201, "a", 2)

    @pytest.mark.parametrize("name", ["tiles", "stones"])
    def test_samples_are_seen_before_they_are_opened(self, served: Served, name: str) -> None:
        drawn = opened(served.bytes(f"/api/samples/{name}.png?side=64"))
        assert max(drawn.shape[:2]) <= 64


class TestSchema:
    def test_every_option_is_offered_or_the_servers_own(self) -> None:
        for verb in requests.VERBS:
            offered, fields = requests.options(verb), [f for f in fields_of_verb(verb) if f.flags]
            left = {f.name for f in fields if f.key not in offered}
            written = {"save_map", "sheet", "page", "preview"}
            assert left <= {f.name for f in fields if f.local} | written

    def test_what_is_told_of_an_option_is_what_the_command_has(self) -> None:
        known = requests.options("heal")
        assert known["mask"]["kind"] == "image"
        assert known["from"]["kind"] == "exemplar"
        grow = requests.options("grow")
        assert grow["size"]["kind"] == "size"
        assert grow["jitter_output"]["image"]
        assert grow["patch"] | {"help": ""} == grow["patch"] | {"help": "", "kind": "extent", "parameter": True}
        assert grow["feather"]["high"] == 1024
