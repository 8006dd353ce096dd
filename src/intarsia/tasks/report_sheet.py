"""A report as one picture: the pictures of the page side by side, the total, and a bar for each part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..files.lettering import lettered
from ..image import Plane
from ..judging.score import Score
from ..rendering.mixing import averaged
from .outcome import Outcome
from .report_page import quality
from .report_pictures import Pixels, pictures_of, stretched

SIDE, GAP = 512, 24  # px of a panel, and between panels
COLUMNS = 5  # panels side by side; the numbers are a sixth
WORD, NUMBER = 18, 96  # px: height of letters
ROW = 44  # px from one part to the next
PAPER, INK, QUIET, TRACK = (250, 250, 248), (29, 29, 27), (102, 102, 95), (226, 226, 220)
BARS = {"bad": (179, 38, 30), "fair": (183, 121, 31), "good": (47, 111, 79)}


def sheet_of(outcome: Outcome) -> Plane:
    """Return the report on one output as a picture of 8 bits."""
    drawn = pictures_of(outcome)
    rows = -(-len(drawn) // COLUMNS)
    deep = SIDE + WORD + 2 * GAP
    needed = NUMBER + 5 * GAP + ROW * len(outcome.score.ranked)
    paper = _paper(max(rows * deep, needed) + GAP, (COLUMNS + 1) * (SIDE + GAP) + GAP)
    for number, one in enumerate(drawn):
        row, column = divmod(number, COLUMNS)
        y, x = GAP + row * deep, GAP + column * (SIDE + GAP)
        _write(paper, y, x, one.title, WORD)
        _lay(paper, y + WORD + GAP // 2, x, fitted(one.pixels, SIDE))
    x = GAP + COLUMNS * (SIDE + GAP)
    _numbers(paper, GAP, x, outcome.score, outcome.missed)
    return Plane(paper)


def index_sheet(outcomes: Sequence[tuple[Outcome, Pixels]]) -> Plane:
    """Return several outputs with their parts as one picture, the worst first."""
    found = sorted(outcomes, key=lambda one: one[0].score.total)
    columns = max(1, min(len(found), 4))
    most = max(len(outcome.score.ranked) for outcome, _ in found)
    deep = SIDE // 2 + 2 * WORD + 4 * GAP + NUMBER + ROW * most
    paper = _paper(-(-len(found) // columns) * deep + GAP, columns * (SIDE + GAP) + GAP)
    for number, (outcome, small) in enumerate(found):
        row, column = divmod(number, columns)
        y, x = GAP + row * deep, GAP + column * (SIDE + GAP)
        _write(paper, y, x, shortened(outcome.name), WORD)
        _lay(paper, y + WORD + GAP // 2, x, fitted(small, SIDE // 2))
        _numbers(paper, y + WORD + GAP + SIDE // 2, x, outcome.score, outcome.missed)
    return Plane(paper)


def shortened(path: str) -> str:
    """Leave out the beginning of a path that is wider than its column: the end tells outputs apart."""
    kept = path[-200:]
    while len(kept) > 1 and lettered("..." * (kept != path) + kept, WORD).shape[1] > SIDE:
        kept = kept[1:]
    return "..." * (kept != path) + kept


def fitted(picture: Pixels, side: int) -> Pixels:
    """Enlarge or reduce a picture, so that its longest side is `side` px."""
    n = max(1, min(max(picture.shape[:2]) // side, *picture.shape[:2]))
    height, width = (m - m % n for m in picture.shape[:2])
    if n > 1:
        picture = averaged(Plane(picture[:height, :width]), n)
    longest = max(picture.shape[:2])
    if longest == side:
        return picture
    size = tuple(max(1, round(m * side / longest)) for m in picture.shape[:2])
    return np.stack([np.rint(stretched(picture[..., c], size)) for c in range(3)], axis=2).astype(np.uint8)


def _paper(height: int, width: int) -> Pixels:
    return np.full((height, width, 3), PAPER, np.uint8)


def _numbers(paper: Pixels, y: int, x: int, found: Score, missed: Sequence[str]) -> None:
    """The total, and a bar from bad to good for each part."""
    _write(paper, y, x, f"{found.total:.0f}", NUMBER)
    _write(paper, y + NUMBER - WORD, x + SIDE // 4 + GAP, found.verdict, WORD)
    y += NUMBER + GAP
    if missed:
        _write(paper, y, x, "falls short: " + ", ".join(missed), WORD, BARS["bad"])
    y += 2 * GAP
    for name in found.ranked:
        one = found.parts[name]
        ink = INK if one.part.weight else QUIET
        _write(paper, y, x, name, WORD, ink)
        _write(paper, y, x + SIDE // 4, f"{one.measured:.1f} {one.part.unit}", WORD, ink)
        taken = f"-{lost:.0f}" if (lost := 100 * found.loss(name)) >= 0.5 else ""
        _write(paper, y, x + SIDE - 2 * WORD, taken, WORD, ink)
        left, right = x + SIDE // 2, x + SIDE - 3 * WORD
        paper[y + WORD // 4 : y + WORD, left:right] = TRACK
        paper[y + WORD // 4 : y + WORD, left : left + round((right - left) * one.worth)] = BARS[quality(one)]
        y += ROW


def _write(paper: Pixels, y: int, x: int, text: str, size: int, ink: tuple[int, int, int] = INK) -> None:
    """Write a line that is cut off where its column ends."""
    cover = lettered(text[:200], size)[:, :SIDE]
    spot = paper[y : y + cover.shape[0], x : x + cover.shape[1]]
    share = cover[: spot.shape[0], : spot.shape[1], None] / 255
    spot[:] = np.rint(spot * (1 - share) + np.array(ink) * share)


def _lay(paper: Pixels, y: int, x: int, picture: Pixels) -> None:
    paper[y : y + picture.shape[0], x : x + picture.shape[1]] = picture
