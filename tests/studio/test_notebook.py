"""Results as a notebook shows them: a part of a page that needs nothing else, below 1 MB, true about each pixel."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from studio.served import opened, pixels

import intarsia as ia

if TYPE_CHECKING:
    from playwright.sync_api import Browser

ALONE = {"img", "br"}


class Balanced(HTMLParser):
    """Notices what is not closed, and keeps what links."""

    def __init__(self) -> None:
        super().__init__()
        self.open, self.links, self.texts = list[str](), list[str](), list[str]()

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.open += [tag] * (tag not in ALONE)
        self.links += [value for name, value in attrs if name in ("src", "href")]
        assert not [name for name, _ in attrs if name.startswith("on")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts += [data] if self.open[-1:] not in (["style"], ["script"]) else []


def parsed(html: str) -> Balanced:
    found = Balanced()
    found.feed(html)
    found.close()
    assert found.open == []
    assert all(link.startswith("data:image/") for link in found.links)
    assert "://" not in html
    assert "url(" not in html
    assert len(html.encode()) < 1_000_000
    return found


def grown(size: Any = (70, 90), method: Any = None, **how: Any) -> ia.Synthesis:
    return ia.synthesize(how.pop("exemplar", pixels(40, 44)), size, method or ia.ImageQuilting(patch=12), **how)


def test_it_is_one_sound_part_of_a_page_and_tells_the_score() -> None:
    made = grown(exemplar=ia.read("sample:tiles"), size=200)
    html = made._repr_html_()
    told = " ".join(parsed(html).texts)
    found = ia.score(made.exemplars[0], made)
    assert f"score {found.total:.1f} of 100, {found.verdict}" in re.sub(r"\s+", " ", told)
    assert "200x200 px" in told
    assert "reduced" not in told
    assert "image-quilting" in told
    assert "tiles" in told
    assert made._repr_html_() != html  # two outputs of one result do not share their names


@pytest.mark.parametrize("kind", ["noise", "clear", "floats", "labels"])
def test_whatever_it_shows_it_stays_small(kind: str) -> None:
    random = np.random.default_rng(3)
    picture: Any = {
        "noise": random.integers(0, 256, (300, 300, 3), np.uint8),
        "clear": random.integers(0, 256, (300, 300, 4), np.uint8),
        "floats": random.random((60, 64, 3)).astype(np.float32) * 3,
        "labels": ia.Plane(np.eye(40, dtype=np.uint32), ia.Kind.LABEL),
    }[kind]
    exemplar = ia.Exemplar.of(picture)
    yx = np.stack([random.integers(0, n, (600, 640)) for n in (exemplar.height, exemplar.width)], axis=2)
    smap = ia.SourceMap(yx.astype(np.int32), None, None, (exemplar.source,))
    html = ia.Synthesis((exemplar,), smap, smap.blend, ia.RandomTiling())._repr_html_()
    told = " ".join(parsed(html).texts)
    assert "640x600 px , shown reduced" in told.replace("px,", "px ,")
    assert len(html) > 20_000


def test_many_exemplars_and_none_too_large() -> None:
    many = [ia.Exemplar.of(pixels(30, 30, seed=n), name=f"e{n}") for n in range(9)]
    told = " ".join(parsed(grown(exemplar=many)._repr_html_()).texts)
    assert all(f"e{n}" in told for n in range(9))
    tiny = ia.synthesize(np.zeros((3, 3), np.uint8), 4, ia.Repeat())
    parsed(tiny._repr_html_())


HOSTILE = '"><img src=x onerror=alert(1)></script><script>alert(2)</script>\u202e\x1b[31m&amp;'


def test_the_name_of_an_exemplar_is_only_a_name() -> None:
    made = grown(exemplar=ia.Exemplar.of(pixels(40, 44), name=HOSTILE))
    found = parsed(made._repr_html_())
    assert len(found.links) == 2
    told = " ".join(found.texts)
    assert "<script>alert(2)</script>" in told
    assert "\u202e" not in told
    assert "\x1b" not in told


def test_the_pointer_is_told_where_each_pixel_comes_from(browser: Browser, tmp_path: Path) -> None:
    """As the map has it, also of several exemplars, of holes, and of a picture that is shown reduced."""
    random, exemplars = np.random.default_rng(5), [pixels(40, 44), pixels(52, 38, seed=8)]
    large = ia.synthesize(pixels(300, 300), (700, 900), ia.ImageQuilting(patch=60))
    named = grown(exemplar=ia.Exemplar.of(pixels(40, 44), name=HOSTILE))
    for made in (grown(exemplar=exemplars, seed=2), named, large):
        page, wrong = browser.new_page(viewport={"width": 1400, "height": 900}), list[str]()
        page.on("pageerror", lambda error, wrong=wrong: wrong.append(str(error)))
        page.on("dialog", lambda dialog, wrong=wrong: wrong.append(dialog.message))
        page.on("request", lambda request, wrong=wrong: wrong.append(request.url) if "http" in request.url else None)
        place = tmp_path / "page.html"
        both = made._repr_html_() + grown()._repr_html_()  # two in one page
        place.write_text(f"<!doctype html><meta charset=utf-8><body>{both}", encoding="utf-8")
        page.goto(place.as_uri())
        picture, line = page.locator("[data-made]").first, page.locator(".where").first
        box = picture.bounding_box()
        assert box is not None
        for _ in range(12):
            line.evaluate("line => { delete line.dataset.place; }")
            v, u = random.random(2)
            page.mouse.move(box["x"] + u * box["width"], box["y"] + v * box["height"])
            page.wait_for_function("line => line.dataset.place", arg=line.element_handle())
            row, column, which, y, x = map(int, str(line.get_attribute("data-place")).split(","))
            assert abs(row - v * made.map.height) <= made.map.height / box["height"] + 1
            assert abs(column - u * made.map.width) <= made.map.width / box["width"] + 1
            assert made.map.yx[row, column].tolist() == [y, x]
            assert (0 if made.map.which is None else made.map.which[row, column]) == which
            assert f"row {y}, column {x} of" in line.inner_text()
            whole = page.locator("[data-from]").nth(which)
            seen, figure, source = whole.locator("i").bounding_box(), whole.bounding_box(), made.exemplars[which]
            assert seen is not None
            assert figure is not None
            assert abs(seen["x"] + seen["width"] / 2 - figure["x"] - (x + 0.5) * figure["width"] / source.width) <= 2
            assert abs(seen["y"] + seen["height"] / 2 - figure["y"] - (y + 0.5) * figure["height"] / source.height) <= 2
        assert wrong == []
        page.close()


def test_the_picture_is_the_picture() -> None:
    made = grown()
    data = re.search(r"data:image/png;base64,([^\"]+)", made._repr_html_())
    assert data is not None
    assert np.array_equal(opened(base64.b64decode(data[1])), made.render().pixels)
