"""The house as its imports tell: which rooms there are, on which floor each lies, and which stands on which."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import intarsia

ROOT = Path(intarsia.__file__).parent

FLOORS = (
    {"errors", "geometry", "lazy", "version"},
    {"arguments", "arrays", "disk", "filtering", "frames", "kernels"},
    {"draws", "field", "image", "run"},
    {"guide", "params"},
    {"levelling"},
    {"sourcemap"},
    {"canvas", "exemplar"},
    {"files", "rendering"},
    {"analysis"},
    {"lattice", "search"},
    {"corrections", "patches", "segments"},
    {"blocks", "pixels", "seams", "tiles"},
    {"courses", "covering", "judging"},
    {"methods"},
    {"choosing"},
    {"request", "synthesis"},
    {"giant", "tasks"},
    {"cli", "testing"},
    {"studio.beside"},
    {"studio"},
    {"cli.commands"},
    {"__init__"},
    {"__main__"},
)
"""The rooms from the ground up: packages, and the modules beside them. A room imports from lower floors alone.

`synthesis` is not `synthesize`: the module would hide the function.
"""

FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}


def modules() -> list[Path]:
    return sorted(ROOT.rglob("*.py"))


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def name_of(path: Path) -> str:
    """Name of a module inside the package, such as ``patches.growth``; that of a package ends in ``__init__``."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


FILES = {name_of(p): p for p in modules()}


def room_of(module: str) -> str:
    """The room that a module lies in; a module beside the rooms is one of its own."""
    return module.rpartition(".")[0] or module


def imports(path: Path) -> Iterator[tuple[str, ...]]:
    """Every module that a file imports as absolute parts, wherever the import stands; lazy ones, too."""
    here = ("intarsia", *path.relative_to(ROOT).with_suffix("").parts)
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from (tuple(a.name.split(".")) for a in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level] if node.level else ()
            base += tuple(node.module.split(".")) if node.module else ()
            yield from ((*base, a.name) for a in node.names)
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("lazy", "importlib.import_module"):
            yield from (tuple(a.value.split(".")) for a in node.args[:1] if isinstance(a, ast.Constant))


@cache
def own(path: Path) -> set[str]:
    """The modules of intarsia that a file imports from, its own room's among them."""
    found = set()
    for parts in imports(path):
        if parts[0] == "intarsia":
            found.add(module_of(parts[1:]))
    return found - {name_of(path)}


def module_of(parts: tuple[str, ...]) -> str:
    """The module that an import names, or that holds the name it ends in."""
    for length in range(len(parts), 0, -1):
        for name in (".".join(parts[:length]), ".".join((*parts[:length], "__init__"))):
            if name in FILES:
                return name
    return "__init__"


def files_in(room: str) -> list[str]:
    """The modules of a room; a module beside the rooms is all of its own."""
    return [m for m in FILES if room_of(m) == room]


def is_package(room: str) -> bool:
    return f"{room}.__init__" in FILES


def told(room: str) -> str:
    """What a room holds: the first line of its docstring."""
    path = FILES[f"{room}.__init__" if is_package(room) else room]
    return (ast.get_docstring(tree(path)) or "").partition("\n")[0]


def links() -> dict[str, set[str]]:
    """The rooms that each room imports from, without those that the others among them already lead to.

    `methods` imports `search`, and `patches`, which imports `search`: only the second is a link of `methods`.
    """
    found = {room: {room_of(o) for m in files_in(room) for o in own(FILES[m])} - {room} for room in FLOOR}

    @cache
    def below(room: str) -> frozenset[str]:
        return frozenset(found[room]).union(*map(below, found[room]))

    return {
        room: {o for o in others if not any(o in below(other) for other in others)} for room, others in found.items()
    }
