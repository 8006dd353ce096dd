"""Write the tables of the documentation that follow from the code: ``make tables``.

Between ``<!-- parameters: SLUG -->`` and ``<!-- end -->`` stands the table of a method's parameters, after
``<!-- options: COMMAND -->`` that of a command's options, after ``<!-- methods -->`` that of all methods, after
``<!-- rules -->`` those of the automatic choice, after ``<!-- rooms -->`` what the rooms of the package hold. A test
compares them with the code.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

import click

from intarsia.choosing.rules import RULES
from intarsia.cli import COMMANDS, cli
from intarsia.cli.verbs import ParameterOption, parameters_of
from intarsia.foundation.params import parameters
from intarsia.methods import METHODS, method_class

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from house import FLOORS, is_package, links, told  # noqa: E402

BLOCK = re.compile(r"(<!-- (parameters|options|methods|rules|rooms)(?:: ([\w-]+))? -->\n).*?(<!-- end -->)", re.DOTALL)


def documents() -> list[Path]:
    """List everything that is written for readers."""
    names = "README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "CODE_OF_CONDUCT.md"
    return [ROOT / name for name in names] + sorted(ROOT.glob("docs/**/*.md"))


def rows(head: tuple[str, ...], lines: Iterable[tuple[str, ...]]) -> str:
    """Return a table in Markdown."""
    cells = [head, tuple("---" for _ in head), *lines]
    return "".join("| " + " | ".join(c.replace("|", "\\|") for c in row) + " |\n" for row in cells)


def parameter_table(slug: str) -> str:
    """Return the parameters of a method as a table."""
    found = parameters(method_class(slug))
    if not found:
        return "No parameters.\n"
    return rows(
        ("parameter", "default", "allowed", "what it does"),
        (
            (f"`{p.name}`", "automatic" if p.default is None else f"`{p.default}`", p.allowed(), p.help)
            for p in found
        ),
    )


def option_table(name: str) -> str:
    """Return the options of a command as a table, but for those that are parameters of methods."""
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    lines = []
    for option in command.params or parameters_of(name):
        if not isinstance(option, click.Option) or isinstance(option, ParameterOption):
            continue
        if not option.hidden and option.help:
            words = ", ".join(f"`{word}`" for word in option.opts)
            value = "" if option.is_flag else f"`{option.make_metavar(click.Context(command))}`"
            lines.append((words, value, option.help))
    return rows(("option", "value", "what it does"), lines)


def method_table() -> str:
    """Return all methods as a table."""
    classes = [method_class(slug) for slug in METHODS]
    return rows(
        ("method", "what it does", "source", "can"),
        (
            (
                f"[`{cls.slug}`]({{methods}}/{cls.slug}.md)",
                cls.summary,
                cls.paper,
                ", ".join(sorted(a.value for a in cls.supports)),
            )
            for cls in classes
        ),
    )


def rule_table() -> str:
    """Return the rules of the automatic choice as a table."""
    return rows(("rule", "when", "method"), ((f"`{r.name}`", r.when, f"`{r.method}`") for r in RULES))


def room_table() -> str:
    """Return what every room holds, from the roof down, and on which rooms it stands."""
    below = links()

    def line(room: str) -> tuple[str, ...]:
        place = room.replace(".", "/") + ("" if is_package(room) else ".py")
        stands = ", ".join(f"`{other}`" for other in sorted(below[room]))
        return f"[`{place}`](../src/intarsia/{place})", told(room).replace("``", "`"), stands

    return rows(("room", "what it holds", "stands on"), (line(r) for rooms in FLOORS[::-1] for r in sorted(rooms)))


def filled(path: Path, text: str) -> str:
    """Return the text of a document with its tables as the code has them."""

    def table(match: re.Match[str]) -> str:
        kind, name = match[2], match[3]
        if kind == "parameters":
            return match[1] + parameter_table(name) + match[4]
        if kind == "rules":
            return match[1] + rule_table() + match[4]
        if kind == "rooms":
            return match[1] + room_table() + match[4]
        if kind == "options":
            assert name in COMMANDS
            return match[1] + option_table(name) + match[4]
        folder = "docs/methods" if path.parent == ROOT else "methods"
        return match[1] + method_table().replace("{methods}", folder) + match[4]

    return BLOCK.sub(table, text)


def main() -> None:
    """Write the tables of all documents."""
    for path in documents():
        text = path.read_text(encoding="utf-8")
        if (new := filled(path, text)) != text:
            path.write_text(new, encoding="utf-8")
            print(path.relative_to(ROOT), file=sys.stderr)


if __name__ == "__main__":
    main()
