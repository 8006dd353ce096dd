"""Figures of a document, made again: pictures numbered as there, and a page with claims and measures."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import files
from ..exemplar import Exemplar
from ..image import Plane
from ..methods.base import make
from ..synthesis import synthesize

SEED = 1


class Panel(NamedTuple):
    """One picture of a figure: its letter, how it is made, what is measured of it, and what the document prints."""

    letter: str
    told: str
    picture: Plane
    measured: str = ""
    printed: str = ""


class Figure(NamedTuple):
    """A figure: its number, what its caption says, what makes its panels from an exemplar, and a built-in one."""

    number: str
    claim: str
    panels: Callable[[Exemplar], list[Panel]]
    usual: str


def given(exemplar: Exemplar) -> Panel:
    """The exemplar itself, which is panel (a)."""
    return Panel("a", "input", exemplar.base)


def cropped(exemplar: Exemplar, side: int) -> Exemplar:
    """The first pixels of an exemplar, as many as a caption says, or all."""
    return Exemplar.of(np.asarray(exemplar.base.pixels)[:side, :side])


def grown(
    letter: str, exemplar: Exemplar, size: int | tuple[int, int], slug: str, settings: dict[str, Any],
    printed: str = "", feather: int | None = None, start: Any = None,
) -> Panel:  # fmt: skip
    """Grow a panel, all with the same seed, its seams mixed as numbers of the file; seconds, and how much is shown."""
    begun = time.perf_counter()
    made = synthesize(exemplar, size, make(slug, settings), seed=SEED, start=start)
    took = time.perf_counter() - begun
    picture = replace(made, blend=made.blend.but(mixing="source", feather=feather)).render()
    shown = len(np.unique(made.map.yx.reshape(-1, 2), axis=0)) / (exemplar.height * exemplar.width)
    told = ", ".join(f"{name} {value}" for name, value in settings.items())
    return Panel(letter, f"{slug}: {told}", picture, f"{took:.2f} s, {100 * shown:.0f} % of the input shown", printed)


def write(title: str, figures: Sequence[Figure], exemplar: Exemplar | None, out: Path) -> Path:
    """Make figures, write every panel, and return the page that shows them beside what is claimed and printed.

    Without an exemplar each is made from the built-in one that suits it.
    """
    out.mkdir(parents=True, exist_ok=True)
    parts = [f"<!doctype html><meta charset=utf-8><title>{escape(title)}</title><h1>{escape(title)}</h1>"]
    for figure in figures:
        parts.append(f"<h2>Figure {figure.number}</h2><p>{escape(figure.claim)}</p><table>")
        for panel in figure.panels(files.read(figure.usual) if exemplar is None else exemplar):
            name = f"figure_{figure.number.replace('.', '_')}_{panel.letter}.png"
            files.write(out / name, panel.picture)
            cells = f"({panel.letter})", f"<img src={name}>", *map(escape, (panel.told, panel.measured, panel.printed))
            parts.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
        parts.append("</table>")
    page = out / "index.html"
    page.write_text("\n".join(parts), encoding="utf-8")
    return page
