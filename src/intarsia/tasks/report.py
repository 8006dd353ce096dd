"""Quality report as one self-contained HTML page: pictures, the score by parts, recipe and command.

    page = ia.report(ia.synthesize("stones.png", 512))

The page has no scripts and loads nothing, which a content security policy enforces; it supports light and dark
colour schemes.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

from ..files.png import encode_png
from ..foundation import InputError, expect, legible
from ..judging import PartScore, Score
from ..synthesis import Synthesis
from .drawings import Pixels, ReportPicture, pictures_of
from .scoring import Outcome

STYLE = """
:root { color-scheme: light dark; --paper: #fafaf8; --ink: #1d1d1b; --quiet: #66665f; --line: #e0e0da; --track: #e7e7e1;
  --bad: #b3261e; --fair: #b7791f; --good: #2f6f4f;
  --s1: 4px; --s2: 8px; --s3: 16px; --s4: 32px; --s5: 64px;
  --t1: 0.8125rem; --t2: 1rem; --t3: 1.375rem; --t4: 3.5rem; }
@media (prefers-color-scheme: dark) { :root { --paper: #171716; --ink: #e9e9e4; --quiet: #9c9c94; --line: #33332f;
  --track: #2b2b28; --bad: #f2857d; --fair: #e3b15c; --good: #7fc8a0; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1440px; padding: var(--s4) var(--s3) var(--s5); background: var(--paper);
  color: var(--ink); font: var(--t2)/1.5 system-ui, sans-serif; }
h1, h2, p, figure, dl, dd { margin: 0; font-weight: 400; }
h1 { font-size: var(--t3); overflow-wrap: anywhere; }
h2 { font-size: var(--t3); margin: var(--s5) 0 var(--s3); overflow-wrap: anywhere; }
small, figcaption, .quiet { font-size: var(--t1); color: var(--quiet); }
header { display: flex; flex-wrap: wrap; gap: var(--s3) var(--s4); align-items: flex-end; margin-bottom: var(--s4); }
header > div { flex: 1 1 20rem; }
.total { font-size: var(--t4); line-height: 1; font-variant-numeric: tabular-nums; }
.missed { border-left: var(--s1) solid var(--bad); padding: var(--s2) var(--s3); margin-bottom: var(--s4); }
.pictures { display: grid; gap: var(--s4) var(--s3);
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); }
.pictures img { display: block; width: 100%; height: auto; background: var(--track); }
.small img { image-rendering: pixelated; }
figcaption { padding-top: var(--s2); }
figcaption b { display: block; font-weight: 600; color: var(--ink); font-size: var(--t2); }
.part { display: grid; grid-template-columns: 14rem 1fr 5rem; gap: var(--s1) var(--s3); align-items: baseline;
  padding: var(--s3) 0; border-top: 1px solid var(--line); }
.part b { font-weight: 600; }
.takes { text-align: right; font-variant-numeric: tabular-nums; }
.bar { display: block; width: 100%; height: var(--s2); background: var(--track); border-radius: var(--s1); }
.bad { fill: var(--bad); } .fair { fill: var(--fair); } .good { fill: var(--good); }
.ends { display: flex; justify-content: space-between; }
dl { display: grid; grid-template-columns: 14rem 1fr; gap: var(--s2) var(--s3); }
dt { color: var(--quiet); } dd { overflow-wrap: anywhere; }
pre { margin: var(--s3) 0; padding: var(--s3); background: var(--track); font-size: var(--t1); white-space: pre-wrap;
  overflow-wrap: anywhere; }
summary { cursor: pointer; padding: var(--s2) 0; }
@media (max-width: 44rem) { dl { grid-template-columns: 1fr; } .part { grid-template-columns: 1fr auto; }
  .part .scale { grid-column: 1 / -1; grid-row: 2; } }
@media print { .bar { print-color-adjust: exact; } figure, .part { break-inside: avoid; } }
"""

_DIGEST = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
RULES = f"default-src 'none'; img-src data:; style-src 'sha256-{_DIGEST}'; base-uri 'none'; form-action 'none'"
"""The content security policy: only embedded pictures and this style are allowed."""

PIXELATED = 256  # px: pictures whose sides are at most this long are enlarged without interpolation


def report(made: Synthesis, name: str = "the output") -> str:
    """Return a quality report on a synthesis as one HTML page: its sources, its score by parts, and local losses.

    Parameters
    ----------
    made : Synthesis
        What :func:`synthesize` or another task returned.
    name : str
        Its name on the page, default "the output".

    Returns
    -------
    str
        The whole page with embedded pictures; write it to a file that ends in ``.html``, as UTF-8.

    Raises
    ------
    InputError
        if `made` is no Synthesis.
    ParameterError
        if `name` is no text.

    Notes
    -----
    docs/reports.md explains the page; the score is that of :func:`score`.
    """
    expect(made, Synthesis, "made", "a Synthesis, as synthesize returns one", InputError)
    expect(name, str, "name", "a word")
    return page_of(Outcome.of(made, name))


def page_of(outcome: Outcome) -> str:
    """Return the HTML page on one output."""
    drawn = pictures_of(outcome)
    output = [d for d in drawn if d.name not in ("exemplar", "usage")]
    exemplar = [d for d in drawn if d not in output]
    body = [
        _head(outcome), _missed(outcome.missed),
        f'<section class="pictures">{"".join(map(_figure, output))}</section>',
        f'<h2>The exemplar</h2><section class="pictures">{"".join(map(_figure, exemplar))}</section>',
        f"<h2>The score</h2>{_parts(outcome.score)}",
        f"<h2>How it was made</h2>{_facts(outcome)}",
    ]  # fmt: skip
    return _page(outcome.name, body)


def _page(title: str, body: Iterable[str]) -> str:
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{RULES}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{_text(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        + "".join(f"{part}\n" for part in body) + "</body>\n</html>\n"
    )  # fmt: skip


def _text(words: object) -> str:
    """Return text escaped for HTML and attributes; characters that cannot be printed become "?"."""
    return escape(legible(str(words)))


def _head(outcome: Outcome) -> str:
    found = outcome.score
    taken = [f"{name} takes {100 * found.loss(name):.0f}" for name in found.ranked[:3] if found.loss(name) >= 0.005]
    said = ", ".join(taken) or "nothing speaks against it"
    return (
        f'<header><div><h1>{_text(outcome.name)}</h1><p class="quiet">{_text(said)}</p></div>'
        f'<p><span class="total">{found.total:.0f}</span> '
        f'<span class="quiet">of 100, {found.verdict}</span></p></header>'
    )


def _missed(missed: Sequence[str]) -> str:
    return f'<p class="missed">Falls short: {_text(", ".join(missed))}.</p>' if missed else ""


def _figure(drawn: ReportPicture) -> str:
    small = ' class="small"' if max(drawn.pixels.shape[:2]) <= PIXELATED else ""
    caption = f"<figcaption><b>{_text(drawn.title)}</b>{_text(drawn.says)}</figcaption>"
    return f"<figure{small}>{_image(drawn.pixels, drawn.title)}{caption}</figure>"


def _image(pixels: Pixels, name: str) -> str:
    data = base64.b64encode(encode_png(pixels)).decode("ascii")
    height, width = pixels.shape[:2]
    return f'<img src="data:image/png;base64,{data}" width="{width}" height="{height}" alt="{_text(name)}">'


def quality(one: PartScore) -> str:
    """Return a word for the normalised score of a part: "good" from 0.8 on, "fair" from 0.4 on, else "bad"."""
    return "good" if one.normalised >= 0.8 else "fair" if one.normalised >= 0.4 else "bad"


def _parts(found: Score) -> str:
    return "".join(_part(name, found) for name in found.ranked)


def _part(name: str, found: Score) -> str:
    one = found.parts[name]
    takes = f"-{lost:.1f}" if (lost := 100 * found.loss(name)) >= 0.05 else "0"
    unit = _text(one.part.unit)
    return (
        f'<div class="part"><div><b>{_text(name)}</b> {one.measured:.1f} {unit}<br>'
        f'<small>{_text(one.part.says)}</small></div><div class="scale">'
        f'<svg class="bar" role="img" aria-label="worth {one.normalised:.2f} of 1" width="100%" height="8">'
        f'<rect class="{quality(one)}" width="{100 * one.normalised:.1f}%" height="8"/></svg>'
        f'<div class="ends"><small>bad {one.bad:.1f} {unit}</small><small>worth {one.normalised:.2f}</small>'
        f"<small>good {one.good:.1f} {unit}</small></div></div>"
        f'<div class="takes">{takes}</div></div>'
    )


def facts_of(outcome: Outcome) -> list[tuple[str, str]]:
    """Return how an output was made, from its recipe, as (key, value) for the report."""
    recipe = outcome.recipe
    said: list[tuple[str, str]] = [(key, _value(recipe[key])) for key in ("method", "seed") if key in recipe]
    said += [("size", f"{outcome.output.width} x {outcome.output.height} px"), ("wrap", outcome.wrap.value)]
    if isinstance(values := recipe.get("parameters"), dict):
        said += [(key.replace("_", " "), _value(value)) for key, value in values.items()]
    said += [(key, _value(recipe[key])) for key in ("blend", "inputs", "depth", "repair", "auto") if key in recipe]
    return said + ([] if outcome.energy is None else [("energy", f"{outcome.energy} knees per million px")])


def _value(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _facts(outcome: Outcome) -> str:
    pairs = "".join(f"<dt>{_text(key)}</dt><dd>{_text(value)}</dd>" for key, value in facts_of(outcome))
    return f"<dl>{pairs}</dl>{_again(outcome)}"


def _again(outcome: Outcome) -> str:
    said = ""
    if outcome.command:
        command = f"<pre>{escape(outcome.command)}</pre>"
        said += f"<details open><summary>The command that makes it again</summary>{command}</details>"
    if outcome.recipe:
        recipe = json.dumps(outcome.recipe, indent=2, sort_keys=True)
        said += f"<details><summary>Its recipe</summary><pre>{escape(recipe)}</pre></details>"
    return said
