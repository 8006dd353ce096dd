"""``intarsia methods``: the list of methods and their parameters. Imports nothing heavy."""

from __future__ import annotations

from typing import Any

import click

from ...foundation.params import parameters
from ...methods import method_class
from .. import debug_option, print_lines, say_json
from ..verbs import entries


@click.command(name="methods")
@click.argument("slug", required=False, metavar="[METHOD]")
@click.option("--json", "as_json", is_flag=True, help="Print a JSON list.")
@debug_option
def command(slug: str | None, as_json: bool) -> None:
    """List the methods, or the parameters of one METHOD."""
    found = entries() if slug is None else entries(slug)
    if as_json:
        say_json(found)
    elif slug is not None:
        print_lines(_page(method_class(slug)))
    else:
        wide = max(len(one["slug"]) for one in found)
        print_lines(f"{one['slug']:{wide}}  {one['summary']} ({one['paper']})" for one in found)


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
