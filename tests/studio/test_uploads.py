"""Files that come in: several at once, which were refused and why, what of them is not used; names, and disk use."""

from __future__ import annotations

import io
import zipfile
from typing import Any

from PIL import Image
from studio.served import QUICK, Served, pixels, png, studio


def sent(served: Served, **files: bytes) -> Any:
    """Send files: name, with __ for its dot -> contents; the answer."""
    parts = [("files", (name.replace("__", "."), data)) for name, data in files.items()]
    return served.client.post("/api/exemplars", files=parts)


def names(served: Served) -> list[str]:
    return [row["name"] for row in sorted(served.get("/api/exemplars"), key=lambda row: -row["created"])]


def test_files_of_several_exemplars_become_one_each(served: Served) -> None:
    maps = {"wall_albedo__png": png(pixels(seed=21)), "wall_normal__png": png(pixels(seed=22))}
    answer = sent(served, first__png=png(pixels(seed=20)), **maps, third__png=png(pixels(seed=23)))
    first = answer.json()
    assert (answer.status_code, first["name"], first["opened"], first["refused"]) == (201, "first", 3, [])
    assert names(served)[:3] == ["first", "wall", "third"]
    wall = max((row for row in served.get("/api/exemplars") if row["name"] == "wall"), key=lambda row: row["created"])
    assert [plane["name"] for plane in wall["planes"]] == ["albedo", "normal"]


def test_numbers_in_names_of_files_stay(served: Served) -> None:
    row = sent(served, **{"IMG-2_2317__png": png(pixels(seed=26))}).json()
    assert row["name"] == "IMG-2_2317"
    made = served.post(f"/api/exemplars/{row['id']}/edit", {"propose": True})
    assert made["name"] == "IMG-2_2317"
    told = zipfile.ZipFile(io.BytesIO(served.bytes(f"/api/exemplars/{made['id']}/for/godot.zip"))).namelist()
    assert "IMG_2_2317_orm.png" in told


def test_each_refusal_names_its_file_and_the_others_open(served: Served) -> None:
    bad = {"empty__png": b"", "vec__svg": b"<svg/>", "cut__png": png(pixels())[:200]}
    answer = sent(served, **bad, good__png=png(pixels(seed=24)))
    assert answer.status_code == 201
    row = answer.json()
    assert (row["name"], row["opened"]) == ("good", 1)
    for start in ("empty.png is empty", "vec.svg is no picture: give PNG", "cut.png"):
        assert any(line.startswith(start) for line in row["refused"]), row["refused"]
    answer = sent(served, empty__png=b"", vec__svg=b"<svg/>")
    assert answer.status_code == 400
    assert "empty.png is empty" in answer.json()["error"]
    assert "vec.svg is no picture" in answer.json()["error"]


def test_what_is_lost_of_a_file_is_told(served: Served) -> None:
    frames, ink, anim = [Image.fromarray(pixels(seed=n)) for n in (1, 2)], io.BytesIO(), io.BytesIO()
    frames[0].save(anim, "GIF", save_all=True, append_images=frames[1:])
    frames[0].convert("CMYK").save(ink, "JPEG")
    assert "anim.gif is animated" in sent(served, anim__gif=anim.getvalue()).json()["told"][0]
    assert "print.jpg is made for print (CMYK)" in sent(served, print__jpg=ink.getvalue()).json()["told"][0]
    told = sent(served, dot__png=png(pixels(12, 12))).json()["told"]
    assert told == ["dot has 12x12 px: below 32 there is hardly a texture."]
    assert "told" not in sent(served, usual__png=png(pixels(seed=25))).json()


def test_names_that_were_given_stay_over_a_restart(tmp_path: Any) -> None:
    with studio(tmp_path / "own") as served:
        row = served.exemplar(wall=png(pixels()))
        job = served.ended(served.job("grow", [row["id"]], **QUICK))
        for kind, each in (("exemplars", row), ("jobs", job)):
            path = f"/api/{kind}/{each['id']}/name"
            assert served.post(path, {"name": " Old wall / north "})["name"] == "Old wall / north"
            assert served.client.post(path, json={"name": "a\nb"}).status_code == 400
            assert served.client.post(path, json={"name": "x" * 81}).status_code == 400
        assert served.client.post(f"/api/exemplars/{row['id']}/name", json={"name": " "}).status_code == 400
        woven = served.post("/api/weaves", {"exemplar": row["id"], "options": {"method": "repeat"}})
        window = served.post(f"/api/weaves/{woven['id']}/window", {"size": "20x20", "origin": "0,0"})
        assert "-o north_woven.png" in window["command"] or "-o _north_woven.png" in window["command"]
    with studio(tmp_path / "own") as served:
        assert served.get(f"/api/exemplars/{row['id']}")["name"] == "Old wall / north"
        assert served.get(f"/api/jobs/{job['id']}")["name"] == "Old wall / north"
        assert served.exemplar(wall=png(pixels()))["name"] == "Old wall / north"
        assert served.post(f"/api/jobs/{job['id']}/name", {"name": ""})["name"] == ""


def test_the_disk_that_is_used_is_told(served: Served) -> None:
    before = served.get("/api/disk")
    assert before["folder"] == str(served.folder)
    served.exemplar(heavy=png(pixels(200, 200, seed=26)))
    assert served.get("/api/disk")["bytes"] > before["bytes"] > 10_000


def test_a_small_window_is_a_picture_with_nothing_beside_it(served: Served, small: str) -> None:
    made = served.done("weave", [small], size="96x80", method="repeat")
    assert [file["name"] for file in made["files"]] == ["small_woven.png"]
