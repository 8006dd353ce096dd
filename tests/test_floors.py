"""The architecture: lower floors never import higher ones, and every library has its one home (DESIGN 3)."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import intarsia

ROOT = Path(intarsia.__file__).parent

FLOORS: dict[str, float] = {
    "errors": 0,
    "field": 0,
    "geometry": 0,
    "draws": 0,
    "lazy": 0,
    "params": 0,
    "levelling": 0,
    "run": 0,
    "kernels": 1,
    "image": 2,
    "colour": 2,
    "normals": 2,
    "frames": 2,
    "guide": 3,
    "sourcemap": 3,
    "canvas": 3,
    "exemplar": 3,
    "files": 3,
    "analysis": 3.5,
    "ground": 4,
    "mixing": 4,
    "magnification": 4,
    "mixers": 4,
    "translucent": 4,
    "render": 4,
    "warped": 4,
    "finish": 4,
    "measure": 4,
    "methods": 4,
    "rules": 4.5,
    "auto": 5,
    "trials": 5.5,
    "starts": 3.2,
    "synthesis": 6,
    "advection": 6.2,
    "healing": 6.2,
    "repairing": 6.2,
    "inspection": 6.2,
    "overlays": 6.2,
    "testing": 6.5,
    "giant": 7,
    "cli": 8,
    "studio": 8,
    "__main__": 9,
    "__init__": 9,
}
"""Floor of every module and package. `synthesis` is not `synthesize`: the module would hide the function."""

UPWARD = {
    ("run", "sourcemap"): "the type of a draft, for the checker only",
    ("image", "files"): "a picture shows itself in notebooks; imported when it does",
}
"""Imports of a higher floor that are known, and why."""

HOMES = {
    "OpenImageIO": {"files"},
    "PIL": {"files"},
    "skimage": {"analysis"},
    "click": {"cli"},
    "rich": {"cli"},
    "numba": {"kernels"},
    "llvmlite": {"kernels"},
    "hypothesis": {"testing"},
    "pytest": {"testing"},
    "zarr": {"giant"},
    "dask": {"giant"},
    "distributed": {"giant"},
    "tifffile": set(),
    "starlette": {"studio"},
    "uvicorn": {"studio"},
}
"""The only packages that may import a library."""

APART = {"render", "files", "cli", "studio", "synthesis", "auto", "giant", "testing", "__init__"}
"""What no method imports."""

FILE_LINES, FUNCTION_LINES, KERNEL_LINES = 320, 60, 90


def modules() -> list[Path]:
    return sorted(ROOT.rglob("*.py"))


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def package_of(path: Path) -> str:
    """Name of the module, or of the package it lies in."""
    return path.relative_to(ROOT).with_suffix("").parts[0]


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


def own(path: Path) -> Iterator[str]:
    """The modules and packages of intarsia that a file imports from."""
    for parts in imports(path):
        if parts[0] == "intarsia":
            yield parts[1] if len(parts) > 1 and parts[1] in FLOORS else "__init__"


@pytest.mark.parametrize("path", modules(), ids=named)
def test_lower_floors_never_import_higher_ones(path: Path) -> None:
    me = package_of(path)
    assert me in FLOORS, f"give {me} a floor"
    for other in own(path):
        if other == "__init__" and only_version(path):
            continue
        assert FLOORS[other] <= FLOORS[me] or (me, other) in UPWARD, f"{me} imports {other}"


def only_version(path: Path) -> bool:
    """True where nothing but the version is taken from the package itself."""
    top = [p for p in imports(path) if p[0] == "intarsia" and (len(p) == 1 or p[1] not in FLOORS)]
    return set(top) <= {("intarsia", "__version__")}


def test_the_exceptions_are_still_needed() -> None:
    found = {(package_of(p), other) for p in modules() for other in own(p) if package_of(p) in FLOORS}
    assert set(UPWARD) <= found


@pytest.mark.parametrize("path", modules(), ids=named)
def test_every_library_has_its_home(path: Path) -> None:
    for parts in imports(path):
        assert package_of(path) in HOMES.get(parts[0], {package_of(path)}), f"{parts[0]} in {named(path)}"


@pytest.mark.parametrize("path", sorted((ROOT / "methods").glob("*.py")), ids=named)
def test_methods_import_neither_the_upper_floors_nor_one_another(path: Path) -> None:
    others = {p.stem for p in (ROOT / "methods").glob("*.py")} - {"base", "parameters", "__init__", path.stem}
    for parts in imports(path):
        if parts[0] == "intarsia":
            assert len(parts) == 1 or parts[1] not in APART, ".".join(parts)
            assert not (parts[1:2] == ("methods",) and set(parts[2:]) & others), ".".join(parts)


def test_modules_of_one_floor_do_not_go_round_in_circles() -> None:
    """At the top of the files only: what a function imports when it runs cannot lock up an import."""
    edges = {package_of(p): set() for p in modules()}
    for path in modules():
        top = ast.Module([n for n in tree(path).body if isinstance(n, (ast.Import, ast.ImportFrom))], [])
        for node in ast.walk(top):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = path.relative_to(ROOT).with_suffix("").parts[: -node.level]
                names = [node.module] if node.module else [a.name for a in node.names]
                edges[package_of(path)] |= {(*base, *n.split("."))[0] for n in names}
    done: set[str] = set()
    while len(done) < len(edges):
        free = {m for m, to in edges.items() if m not in done and not (to & set(edges)) - done - {m}}
        assert free, f"circle among {sorted(set(edges) - done)}"
        done |= free


@pytest.mark.parametrize("path", modules(), ids=named)
def test_files_and_functions_stay_short(path: Path) -> None:
    """At most 320 lines a file, 60 a function (90 a kernel), its docstring not counted; at most 8 parameters."""
    assert len(path.read_text(encoding="utf-8").splitlines()) <= FILE_LINES
    kernels = package_of(path) == "kernels"
    for node in ast.walk(tree(path)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            first = node.body[0]
            told = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and len(node.body) > 1
            said = (first.end_lineno or 0) - first.lineno + 1 if told else 0
            lines = (node.end_lineno or 0) - node.lineno + 1 - said
            assert lines <= (KERNEL_LINES if kernels else FUNCTION_LINES), node.name


@pytest.mark.parametrize("path", modules(), ids=named)
def test_names_say_what_is_in_a_file(path: Path) -> None:
    assert not {"utils", "util", "core", "_shared", "shared", "common", "helpers", "misc"} & set(
        path.relative_to(ROOT).with_suffix("").parts
    )


@pytest.mark.parametrize("path", modules(), ids=named)
def test_every_file_begins_with_a_sentence(path: Path) -> None:
    told = ast.get_docstring(tree(path))
    assert told
    assert told.splitlines()[0].endswith((".", ":", "?"))


@pytest.mark.parametrize("path", modules(), ids=named)
def test_nothing_but_draws_makes_randomness(path: Path) -> None:
    """No generator, seeded or not; `secrets` is for `--seed random` alone."""
    for parts in imports(path):
        assert parts[0] != "random"
        assert parts[:2] != ("numpy", "random")
        assert parts[0] != "secrets" or package_of(path) == "cli"
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Attribute) and node.attr in ("random", "default_rng"):
            assert ast.unparse(node.value) not in ("np", "numpy", "np.random", "numpy.random"), named(path)


@pytest.mark.parametrize("path", modules(), ids=named)
def test_kernels_never_trade_exactness_for_speed(path: Path) -> None:
    """No fastmath, no parallel loops, no `prange`: a decision never depends on the machine (DESIGN 4)."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.keyword) and node.arg in ("fastmath", "parallel"):
            assert isinstance(node.value, ast.Constant)
            assert not node.value.value
        assert not (isinstance(node, ast.Name) and node.id == "prange")


@pytest.mark.parametrize("path", modules(), ids=named)
def test_nothing_is_read_that_can_hide_code(path: Path) -> None:
    """R-11: no pickle, no eval of files, no network."""
    banned = {"pickle", "marshal", "shelve", "urllib", "http", "socket", "requests"}
    for parts in imports(path):
        assert parts[0] not in banned
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Call):
            assert ast.unparse(node.func) not in ("eval", "exec")
            for k in node.keywords:
                assert not (k.arg == "allow_pickle" and ast.unparse(k.value) != "False")
