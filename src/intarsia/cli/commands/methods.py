"""``intarsia methods``: what there is to choose from. Imports nothing heavy."""

from __future__ import annotations

from typing import Any

import click

from ...foundation.params import parameters
from ...methods import METHODS, method_class
from .. import say, say_json
from ..verbs import entries


@click.command(name="methods")
@click.argument("slug", required=False, metavar="[METHOD]")
@click.option("--json", "as_json", is_flag=True, help="Print a JSON list.")
@click.option("--debug", is_flag=True, expose_value=False, hidden=True)
def command(slug: str | None, as_json: bool) -> None:
    """List the methods, or the parameters of one METHOD."""
    slugs = tuple(METHODS) if slug is None else (slug,)
    classes = list(map(method_class, slugs))
    if as_json:
        say_json(entries(*slugs))
    elif slug is not None:
        say(_page(classes[0]))
    else:
        wide = max(len(cls.slug) for cls in classes)
        say(f"{cls.slug:{wide}}  {cls.summary} ({cls.paper})" for cls in classes)


def _page(cls: type[Any]) -> list[str]:
    lines = [
        f"{cls.slug}: {cls.summary}",
        f"paper: {cls.paper}",
        f"supports: {', '.join(sorted(a.value for a in cls.supports)) or 'nothing beyond a plain canvas'}",
    ]
    for p in parameters(cls):
        default = "automatic" if p.default is None else p.default
        lines += ["", f"--{p.name.replace('_', '-')} ({p.allowed()}; default {default})", f"    {p.help}"]
    return lines
