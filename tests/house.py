"""The house as its imports tell: which rooms there are, on which floor each lies, and which stands on which.

`python tests/house.py` prints how large each room is, and how large it may be.
"""

from __future__ import annotations

import ast
import io
import tokenize
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import intarsia

ROOT = Path(intarsia.__file__).parent

FLOORS = (
    {"foundation", "version"},
    {"disk", "kernels"},
    {"model", "plugins"},
    {"files", "methods", "rendering"},
    {"analysis"},
    {"lattice", "search"},
    {"corrections", "materials", "patches", "segments"},
    {"regular", "seams"},
    {"judging"},
    {"choosing"},
    {"request", "synthesis"},
    {"giant", "tasks"},
    {"cli", "published", "testing"},
    {"studio.workers"},
    {"studio"},
    {"cli.commands"},
    {"__init__"},
    {"__main__"},
)
"""The rooms from the ground up: packages, and the modules beside them. A room imports from lower floors alone.

`synthesis` is not `synthesize`: the module would hide the function.
"""

LEAF = "published"
"""The room that nothing else imports: what is there because a paper has it, one package a document."""

FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}


HOSTS = ROOT / "plugins" / "hosts"
"""Files that other programs run: no rooms of the house, and no part of what it imports."""


def modules() -> list[Path]:
    return sorted(path for path in ROOT.rglob("*.py") if HOSTS not in path.parents)


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def name_of(path: Path) -> str:
    """Name of a module inside the package, such as ``patches.repetition``; that of a package ends in ``__init__``."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


FILES = {name_of(p): p for p in modules()}


def room_of(module: str) -> str:
    """The room that a module lies in; a module beside the rooms is one of its own, and all that papers have is one."""
    return LEAF if module.startswith(f"{LEAF}.") else module.rpartition(".")[0] or module


def document_of(module: str) -> str:
    """The package of the leaf that a module lies in, such as ``published.multrus2003``; empty elsewhere."""
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] == LEAF and len(parts) > 2 else ""


def imports(path: Path) -> Iterator[tuple[str, ...]]:
    """Every module that a file imports as absolute parts, wherever the import stands: lazy ones, those of its stub."""
    here, stub = ("intarsia", *path.relative_to(ROOT).with_suffix("").parts), path.with_suffix(".pyi")
    for node in (node for file in (path, stub) if file.exists() for node in ast.walk(tree(file))):
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


LAYOUT = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING,
    tokenize.ENDMARKER,
}  # fmt: skip


def tokens(text: str) -> int:
    """How much code a text holds: its tokens without comments, docstrings and layout, so that long lines win nothing.

    An f-string is one token, as Python 3.11 reads it.
    """
    left_out = {(d.lineno, d.col_offset) for d in map(_docstring, ast.walk(ast.parse(text))) if d is not None}
    opening, closing = getattr(tokenize, "FSTRING_START", None), getattr(tokenize, "FSTRING_END", None)
    count = inside = 0
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        count += not inside and token.type not in LAYOUT and token.start not in left_out
        inside += (token.type == opening) - (token.type == closing)
    return count


def _docstring(node: ast.AST) -> ast.Expr | None:
    """The docstring of a module, a class or a function, as the statement that it is."""
    documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    first = node.body[0] if isinstance(node, documented) and node.body else None
    found = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str)
    return first if found and isinstance(first, ast.Expr) else None


BUDGET = {
    "analysis": 16_280,
    "choosing": 5_272,
    "cli": 21_730,
    "corrections": 19_852,
    "foundation": 9_289,
    "model": 9_945,
    "disk": 2_783,
    "files": 13_524,
    "giant": 6_960,
    "judging": 9_777,
    "kernels": 14_333,
    "lattice": 12_417,
    "materials": 3_770,
    "methods": 3_815,
    "plugins": 856,
    "patches": 12_429,
    "published": 28_217,
    "regular": 32_780,
    "rendering": 18_436,
    "request": 9_111,
    "root": 2_601,
    "seams": 18_490,
    "search": 12_574,
    "segments": 4_709,
    "studio": 27_537,
    "tasks": 16_871,
    "testing": 4_852,
}
"""Most tokens of each room, the rooms in it counted, and of the modules beside the rooms (root).

Whoever adds an engine removes what it beats; a room that grows says why in docs/design, with figures.
"""


def sizes() -> Counter[str]:
    """The tokens of every room of `BUDGET`."""
    found = Counter[str]()
    for path in modules():
        inner = path.relative_to(ROOT).parts
        found[inner[0] if len(inner) > 1 else "root"] += tokens(path.read_text(encoding="utf-8"))
    return found


def main() -> None:
    """Print each room's tokens beside its budget, and their sum."""
    found = sizes()
    for room, size in found.most_common():
        print(f"{room:12} {size:7,} of {BUDGET.get(room, 0):7,}")
    print(f"{'all':12} {found.total():7,} of {sum(BUDGET.values()):7,} tokens in {len(FILES)} files")


if __name__ == "__main__":
    main()
