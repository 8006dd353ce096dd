"""Write the tables of the documentation that follow from the code: ``make tables``.

Between ``<!-- parameters: SLUG -->`` and ``<!-- end -->`` stands the table of a method's parameters, after
``<!-- options: COMMAND -->`` that of a command's usual options, after ``<!-- methods -->`` that of all methods, after
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
from intarsia.cli import cli
from intarsia.cli.verbs import _row, parameters_of
from intarsia.foundation.params import parameters
from intarsia.methods import METHODS, method_class
from intarsia.request import FIELDS

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
    """Return the parameters of a method as a table, but for those of the method that it is made of."""
    cls = method_class(slug)
    bases = [base for base in map(method_class, METHODS) if base is not cls and issubclass(cls, base)]
    known = {p.name for base in bases for p in parameters(base)}
    found = [p for p in parameters(cls) if p.name not in known]
    lines = ((f"`{p.name}`", "auto" if p.default is None else f"`{p.default}`", p.allowed(), p.help) for p in found)
    return rows(("parameter", "default", "allowed", "what it does"), lines) if found else "No parameters.\n"


def usual(name: str) -> dict[str, str]:
    """Return the options that the plain help of a command lists, and what they do."""
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    rare = {field.name for field in FIELDS if field.rare}
    options = (o for o in command.params or parameters_of(name) if isinstance(o, click.Option) and not o.hidden)
    context = click.Context(command)
    return dict(_row(context, o, whole=False) for o in options if o.name not in rare and type(o) is click.Option)


def option_table(name: str) -> str:
    """Return the usual options of a command as a table, and the names of those that grow has, too."""
    known = {} if name == "grow" else usual("grow")
    found = usual(name)
    own = ((f"`{words}`", said) for words, said in found.items() if known.get(words) != said)
    shared = (re.findall("--[a-z-]+", words)[0] for words, said in found.items() if known.get(words) == said)
    same = ", ".join(f"`{name}`" for name in shared)
    return rows(("option", "what it does"), own) + (f"\nAs for [grow](#grow): {same}.\n" if same else "")


def method_table() -> str:
    """Return all methods as a table."""
    lines = (
        (f"[`{c.slug}`](methods/{c.slug}.md)", c.summary, c.paper, ", ".join(sorted(a.value for a in c.supports)))
        for c in map(method_class, METHODS)
    )
    return rows(("method", "what it does", "source", "can"), lines)


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
    made = {"parameters": parameter_table, "options": option_table}
    lists = {"methods": method_table, "rules": rule_table, "rooms": room_table}
    return BLOCK.sub(lambda m: m[1] + (made[m[2]](m[3]) if m[3] else lists[m[2]]()) + m[4], text)


def main() -> None:
    """Write the tables of all documents."""
    for path in documents():
        text = path.read_text(encoding="utf-8")
        if (new := filled(path, text)) != text:
            path.write_text(new, encoding="utf-8")
            print(path.relative_to(ROOT), file=sys.stderr)


if __name__ == "__main__":
    main()
