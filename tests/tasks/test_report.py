"""Reports: whole pages that need nothing else, with every part, every picture and no text that is taken for a tag."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Callable
from html.parser import HTMLParser
from io import BytesIO

import numpy as np
import pytest
from judging.naive_windows import blobs
from PIL import Image

import intarsia as ia
from intarsia.tasks.drawings import LARGE, pictures_of, stretched, thumbnail
from intarsia.tasks.report import page_of
from intarsia.tasks.scoring import Outcome, outcome_of

STONES = (blobs(96, 96, 1) // 4).astype(np.uint8)
HOSTILE = "</title><script>alert('1')</script>\"&\x1b[31m\u202ea\nb.png"
EMPTY = {"meta", "img", "br", "!doctype"}


class Page(HTMLParser):
    """Reads a page as strictly as one may: every tag that is opened is closed, in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.words: list[str] = []
        self.pictures: list[Image.Image] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag not in EMPTY:
            self.open.append(tag)
        facts = dict(attrs)
        assert not [name for name in facts if name.startswith("on") or name in ("href", "action", "style")]
        if tag == "img":
            kind, _, data = (facts["src"] or "").partition(",")
            assert kind == "data:image/png;base64"
            picture = Image.open(BytesIO(base64.b64decode(data, validate=True)))
            picture.load()
            assert picture.size == (int(facts["width"] or 0), int(facts["height"] or 0))
            assert facts["alt"]
            self.pictures.append(picture)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(self.words)


def grown(size: int = 128, wrap: str = "none", **given: object) -> ia.Synthesis:
    return ia.synthesize(STONES, size, ia.ImageQuilting(patch=24), wrap=wrap, **given)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def made() -> ia.Synthesis:
    return grown(wrap="both")


def test_a_page_holds_all_and_needs_nothing(made: ia.Synthesis) -> None:
    text = ia.report(made, "stones <grown>.png")
    page = Page(text)
    assert {"html", "head", "body", "title", "style", "figure", "details"} <= set(page.tags)
    assert "script" not in page.tags
    assert not re.search(r"https?:|<script|url\(|@import|<link", text)
    assert "prefers-color-scheme: dark" in text
    assert "stones <grown>.png" in page.text
    found = ia.score(STONES, made)
    assert f"of 100, {found.verdict}" in page.text
    for name in found.ranked:
        one = found.parts[name]
        for said in (name, f"{one.measured:.1f} {one.part.unit}", one.part.says, f"worth {one.normalised:.2f}"):
            assert said in page.text
        assert f"good {one.good:.1f}" in page.text
        assert f"bad {one.bad:.1f}" in page.text
    losses = [found.loss(name) for name in found.ranked]
    assert losses == sorted(losses, reverse=True)
    places = [page.text.index(found.parts[name].part.says) for name in found.ranked]
    assert places == sorted(places)
    assert len(page.pictures) == 6
    for said in ("image-quilting", "patch", "seed", "sha256", "Repeated 3 x 3", "The pieces", "How often it is shown"):
        assert said in page.text


def test_a_page_allows_nothing_but_its_pictures_and_its_style(made: ia.Synthesis) -> None:
    """So it may be opened, and served, where inline scripts and styles are refused; headings are of one tree."""
    text = ia.report(made)
    style = re.search(r"<style>(.*?)</style>", text, re.DOTALL)
    assert style is not None
    digest = base64.b64encode(hashlib.sha256(style[1].encode()).digest()).decode()
    rules = re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', text)
    assert rules is not None
    assert rules[1].startswith(f"default-src 'none'; img-src data:; style-src 'sha256-{digest}';")
    assert text.index("Content-Security-Policy") < text.index("<style>")
    page = Page(text)
    assert page.tags.count("h1") == 1
    assert page.tags.index("h1") < page.tags.index("h2")
    assert page.tags.count("rect") == page.tags.count("svg") > 0


def test_the_output_on_the_page_is_the_output(made: ia.Synthesis) -> None:
    page = Page(ia.report(made))
    assert np.array_equal(np.asarray(page.pictures[0]), np.asarray(made))
    assert np.array_equal(np.asarray(page.pictures[1]), np.tile(np.asarray(made), (3, 3, 1)))


def test_no_text_is_taken_for_a_tag(made: ia.Synthesis) -> None:
    outcome = Outcome.of(made, HOSTILE).but(
        command=HOSTILE, missed=(HOSTILE,), recipe={"method": HOSTILE, "seed": 1, "parameters": {HOSTILE: HOSTILE}}
    )
    outcome = outcome.but(exemplars=tuple(ia.Exemplar.of(e, name=HOSTILE) for e in outcome.exemplars))
    page = Page(page_of(outcome))
    assert "script" not in page.tags
    assert "alert('1')" in page.text


def test_the_same_output_gives_the_same_page(made: ia.Synthesis) -> None:
    assert ia.report(made) == ia.report(made)


def test_good_and_broken_are_told_apart_at_a_glance() -> None:
    """Much of the picture of joins is red where pieces are small, little of a good one."""

    def red(pixels: np.ndarray) -> float:
        wide = pixels.astype(int)
        return float((wide[..., 0] - wide[..., 2] > 60).mean())

    whole, tiles = (ia.synthesize(STONES, 128, method) for method in (ia.Repeat(), ia.RandomTiling(patch=8)))
    good, bad = ({d.name: d.pixels for d in pictures_of(Outcome.of(m))} for m in (whole, tiles))
    assert red(bad["joins"]) > 0.5
    assert red(good["joins"]) < red(bad["joins"]) / 2
    assert len(np.unique(bad["pieces"].reshape(-1, 3), axis=0)) > len(np.unique(good["pieces"].reshape(-1, 3), axis=0))


def test_a_picture_alone_has_no_map_to_show() -> None:
    drawn = [one.name for one in pictures_of(outcome_of(STONES, STONES))]
    assert drawn == ["output", "joins", "exemplar"]


def test_what_is_shown_often_is_light_and_what_is_not_is_dark() -> None:
    usable = np.mgrid[:96, :96][0] < 80
    made = ia.synthesize(ia.Exemplar.of(STONES, usable=usable), 96, ia.RandomTiling(patch=96 // 2))
    drawn = {one.name: one.pixels for one in pictures_of(Outcome.of(made))}["usage"].astype(int).sum(axis=2)
    (counts,) = made.map.usage()
    assert drawn[(counts > 1) & usable].mean() > 1.3 * drawn[(counts == 1) & usable].mean()
    assert drawn[(counts == 1) & usable].mean() > 1.5 * drawn[(counts == 0) & usable].mean()
    assert (drawn[~usable] == 3 * 128).all()


QUILTED = ia.ImageQuilting(patch=24)
KINDS: dict[str, Callable[[], ia.Synthesis]] = {
    "gray": lambda: ia.synthesize(STONES[:, :, 0], 100, QUILTED),
    "16 bit": lambda: ia.synthesize(STONES.astype(np.uint16) * 257, 100, QUILTED),
    "float": lambda: ia.synthesize((STONES / 255).astype(np.float32), 100, QUILTED),
    "alpha": lambda: ia.synthesize(np.dstack([STONES, np.full((96, 96), 200, np.uint8)]), 100, QUILTED),
    "planes": lambda: ia.synthesize({"albedo": STONES, "height": STONES[:, :, 0]}, 100, QUILTED),
    "masked": lambda: ia.synthesize(ia.Exemplar.of(STONES, usable=np.mgrid[:96, :96][0] < 80), 100, QUILTED),
    "magnified": lambda: ia.synthesize(ia.magnified(ia.Exemplar.of(STONES.repeat(2, 0).repeat(2, 1)), 2), 96, QUILTED),
    "several": lambda: ia.synthesize([STONES, STONES[::-1, :80]], 100, QUILTED),
    "tiny": lambda: ia.synthesize(STONES[:9, :11], 13, ia.Repeat()),
    "wrapped": lambda: ia.synthesize(STONES, (40, 200), QUILTED, wrap="x"),
    "turned": lambda: ia.synthesize(STONES, 96, ia.ParallelControllable(angle=20)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_picture_has_a_report(kind: str) -> None:
    assert len(Page(ia.report(KINDS[kind]())).pictures) >= 5


def test_large_pictures_are_shown_smaller() -> None:
    assert thumbnail(ia.Plane(np.zeros((3000, 20, 3), np.uint8)), LARGE).shape == (1024, 7, 3)
    assert thumbnail(ia.Plane(np.zeros((2000, 1, 3), np.uint8)), LARGE).shape == (1024, 1, 3)
    assert thumbnail(ia.Plane(np.full((4, 4), 7, np.uint8)), LARGE).tolist() == [[[7, 7, 7]] * 4] * 4


def test_stretched_keeps_slopes() -> None:
    slope = np.add.outer(np.arange(6.0), 2 * np.arange(9.0))
    wide = stretched(slope, (24, 36))
    rows, columns = (np.arange(24) + 0.5) / 4 - 0.5, (np.arange(36) + 0.5) / 4 - 0.5
    assert wide[2:-2, 2:-2] == pytest.approx(np.add.outer(rows, 2 * columns)[2:-2, 2:-2], abs=1e-4)


def test_only_a_synthesis_has_a_report() -> None:
    with pytest.raises(ia.InputError, match="Synthesis"):
        ia.report(STONES)  # type: ignore[arg-type]
