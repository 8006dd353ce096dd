"""Reproduction of a document's figures: numbered pictures, and an HTML page with claims, measures and verdicts."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import intarsia as ia
from intarsia.methods import make

SEED = 1
MEASURES = """s: seconds it took, compiling included where a kernel is used for the first time.
shown: % of the input that is seen. most: how often its most frequent pixel is seen. whole: % of neighbours that are
neighbours in the input. seams: what they cost, in knees per million px. sharp: steps from pixel to pixel, in % of the
input's. agree: % of pixels of the label that is asked for. differences: of pixels, for each that is grown, by the
laws of the thesis. compared: % of all patches that a window is compared with. Verdicts go by counts, not by seconds."""


class Panel(NamedTuple):
    """One picture of a figure: how it was made, what was measured of it, and the number the document prints."""

    told: str
    picture: ia.Plane
    values: dict[str, float] = {}  # noqa: RUF012
    printed: str = ""


Way = Callable[[ia.Exemplar], Panel]
Panels = Callable[[ia.Exemplar], list[Panel]]


class Figure(NamedTuple):
    """A figure: its number, the claim of its caption, a function that makes its panels from an exemplar.

    `rising`: the claim in numbers, such as ``"seams c b; agree 90 d"``: a measure, and the panels (or bounds) along
    which it must rise strictly. `usual`: the built-in exemplar. `letters`: of the panels, in order.
    """

    number: str
    claim: str
    panels: Panels
    rising: str = ""
    usual: str = "sample:pebbles"
    letters: str = "abcdef"

    def verdict(self, panels: Sequence[Panel]) -> str:
        """Return whether the measures confirm the claim: all rules hold, some, or none."""
        if not self.rising:
            return "To be judged by eye."
        values, held = {k: panel.values for k, panel in zip(self.letters, panels, strict=False)}, []
        for rule in self.rising.split("; "):
            name, *along = rule.split()
            found = [values[a][name] if a in values else float(a) for a in along]
            held.append(found == sorted(set(found)))
        return f"{'Shown' if all(held) else 'Partly shown' if any(held) else 'Not shown'} (rising: {self.rising})."


def given(exemplar: ia.Exemplar) -> Panel:
    """Return the exemplar itself as a panel, (a) of most figures."""
    return Panel("input", exemplar.base)


def cropped(exemplar: ia.Exemplar, side: int) -> ia.Exemplar:
    """Return the upper left `side` x `side` px of an exemplar, or all of it if it is smaller."""
    return ia.Exemplar.of(np.asarray(exemplar.base.pixels)[:side, :side])


def steps(plane: ia.Plane) -> float:
    """Return the mean absolute difference of horizontally adjacent samples."""
    return float(np.abs(np.diff(plane.samples.astype(np.float64), axis=1)).mean())


def measured(made: ia.Synthesis, picture: ia.Plane) -> dict[str, float]:
    """Return the measures of a synthesized picture, as MEASURES explains them."""
    yx, exemplar = made.map.yx, made.exemplars[0]
    _, counts = np.unique(yx.reshape(-1, 2), axis=0, return_counts=True)
    together = np.abs(np.diff(yx, axis=1)).sum(axis=2) == 1
    return {
        "shown": 100 * len(counts) / (exemplar.height * exemplar.width), "most": float(counts.max()),
        "whole": 100 * float(together.mean()), "seams": float(made.energy),
        "sharp": 100 * steps(picture) / max(steps(exemplar.base), 1e-9),
    }  # fmt: skip


def row(*ways: Way, side: int | None = None) -> Panels:
    """Return a function that makes one panel by each of `ways`, from the first `side` px of an exemplar or from all."""

    def panels(exemplar: ia.Exemplar) -> list[Panel]:
        shown = exemplar if side is None else cropped(exemplar, side)
        return [way(shown) for way in ways]

    return panels


def synthesized(
    size: int | tuple[int, int] | None, slug: str, settings: dict[str, Any], printed: str = "",
    feather: int | None = None, **more: Any,
) -> Way:  # fmt: skip
    """Return a function that synthesizes a panel, always with SEED, seams mixed in the file's own values.

    `size` None: twice the input. `more`: a start map or a guide.
    """

    def panel(exemplar: ia.Exemplar) -> Panel:
        begun = time.perf_counter()
        made = ia.synthesize(exemplar, size, make(slug, settings), seed=SEED, **more)
        took = time.perf_counter() - begun
        picture = replace(made, blend=made.blend.but(mixing="source", feather=feather)).render()
        values = {"s": took} | measured(made, picture)
        guide = more.get("guide")
        if guide is not None:
            wanted, there = np.asarray(guide.target.pixels), np.asarray(guide.sources[0].pixels)
            values["agree"] = 100 * float((there[*np.moveaxis(made.map.yx, 2, 0)] == wanted).mean())
        return Panel(f"{slug}: {listed(settings)}", picture, values, printed)

    return panel


def listed(settings: dict[str, Any]) -> str:
    """Return settings in one line."""
    return ", ".join(f"{name} {value}" for name, value in settings.items())


def shaded(values: np.ndarray, low: float | None = None, high: float | None = None) -> Any:
    """Return a map of numbers in gray, black at `low`, white at `high` (by default its extremes) and for NaN."""
    low, high = (np.nanmin(values) if low is None else low), (np.nanmax(values) if high is None else high)
    return np.nan_to_num((values - low) / (high - low) * 255, nan=255).astype(np.uint8)


def log_plot(x: np.ndarray, curves: dict[str, np.ndarray]) -> ia.Plane:
    """Draw curves over x on a logarithmic y axis, each labelled at its end with its name, first and last value."""
    page = np.full((360, 640), 255, np.uint8)
    page[20:341, 40] = page[340, 40:441] = 128
    logs = np.log10([*curves.values()])
    rows = 340 - 320 * (logs - logs.min()) / np.ptp(logs)
    dense = np.linspace(x[0], x[-1], 8000)
    for row in rows:
        page[np.interp(dense, x, row).astype(int), np.linspace(40, 440, 8000).astype(int)] = 0
    paper = Image.fromarray(page)
    for (name, curve), row in zip(curves.items(), rows, strict=True):
        label = f"{name}: {curve[0]:.2g} to {curve[-1]:.2g}"
        ImageDraw.Draw(paper).text((446, int(row[-1])), label, fill=0, font=ImageFont.load_default(12))
    return ia.Plane(np.array(paper))


def write(title: str, figures: Sequence[Figure], exemplar: ia.Exemplar | None, out: Path) -> Path:
    """Make figures, write every panel, and return the path of the page that shows them with claims and measures.

    Without an exemplar each figure uses its built-in one.
    """
    out.mkdir(parents=True, exist_ok=True)
    parts = [f"<!doctype html><meta charset=utf-8><title>{escape(title)}</title><h1>{escape(title)}</h1><p>{MEASURES}"]
    for figure in figures:
        panels = figure.panels(ia.read(figure.usual) if exemplar is None else exemplar)
        said = escape(f"{figure.claim} {figure.verdict(panels)}")
        parts.append(f"<h2>Figure {figure.number}</h2><p>{said}<table>")
        for letter, panel in zip(figure.letters, panels, strict=False):
            name = f"figure_{figure.number.replace('.', '_')}_{letter}.png"
            ia.write(out / name, panel.picture)
            values = ", ".join(f"{key} {value:.4g}" for key, value in panel.values.items())
            cells = f"({letter})", f"<img src={name}>", *map(escape, (panel.told, values, panel.printed))
            parts.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
        parts.append("</table>")
    page = out / "index.html"
    page.write_text("\n".join(parts), encoding="utf-8")
    return page
