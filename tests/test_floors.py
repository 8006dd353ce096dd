"""The house: which room stands on which, no circles, every library in its home, short files and functions."""

from __future__ import annotations

import ast
from collections.abc import Callable
from pathlib import Path

import pytest
from house import (
    BUDGET,
    FILES,
    FLOOR,
    LEAF,
    ROOT,
    document_of,
    imports,
    modules,
    name_of,
    named,
    own,
    room_of,
    sizes,
    tokens,
    tree,
)  # fmt: skip

from intarsia.methods import METHODS, Ability, method_class

PUBLIC = {
    "": "the names of the package",
    "files": "reading and writing without a synthesis",
    "giant": "endless textures",
    "testing": "what makers of methods test with",
}
"""Rooms whose `__init__` hands on names, and what for."""

HOMES = {
    "OpenImageIO": {"files"},
    "PIL": {"files", "model", "tasks"},
    "click": {"cli", "studio"},
    "rich": {"cli"},
    "starlette": {"studio"},
    "uvicorn": {"studio"},
    "llvmlite": {"kernels"},
    "hypothesis": {"testing"},
    "pytest": {"testing"},
    "tifffile": {"giant"},
    "zarr": {"giant"},
    "dask": {"giant"},
    "distributed": {"giant"},
}
"""The only packages that may import a library. numba is for kernels alone."""

TYPES = {"Array", "Mask", "UInt8", "Int16", "Int32", "Int64", "Float32", "Floats", "Pair"}
"""All that kernels may have of `foundation.arrays`: names of types, which nothing calls."""

SHARED = {"foundation.geometry", "foundation.arrays"}
"""What kernels may import that are no kernels."""

HIDING = {"kernels/compiling.py": {"pickle"}}
"""What compiled kernels are kept as; opened after its place, its length and its digest are found right."""

FILE_LINES, FUNCTION_LINES, KERNEL_LINES = 500, 60, 90
PARAMETERS, KERNEL_PARAMETERS = 8, 12

MANY = {
    "synthesize": (9, "what users call: each has a default, all but three are keywords alone"),
}
"""Functions with more parameters than there should be, how many, and why. The list only shrinks."""


def package_of(path: Path) -> str:
    """Name of the module, or of the package it lies in."""
    return path.relative_to(ROOT).with_suffix("").parts[0]


def is_kernel(path: Path) -> bool:
    return package_of(path) == "kernels" or path.stem.endswith("_kernels")


def of_every_module(rule: Callable[[Path], None]) -> Callable[[], None]:
    """Make one test of a rule for all modules: each is looked at in no time."""

    def test() -> None:
        for path in modules():
            try:
                rule(path)
            except AssertionError as e:
                raise AssertionError(f"{named(path)}: {e}") from e

    test.__name__, test.__doc__ = rule.__name__, rule.__doc__
    return test


@of_every_module
def test_lower_floors_never_import_higher_ones(path: Path) -> None:
    me = room_of(name_of(path))
    assert me in FLOOR, f"give {me} a floor"
    for other in map(room_of, own(path)):
        assert other == me or FLOOR[other] < FLOOR[me], f"{me} imports {other}"


@of_every_module
def test_what_is_there_because_a_paper_has_it_is_imported_by_nobody(path: Path) -> None:
    """The table of methods names it by strings, the package hands its classes on; no paper knows of another."""
    documents = set(map(document_of, own(path))) - {"", document_of(name_of(path))}
    inside = room_of(name_of(path)) == LEAF and not documents
    assert inside or LEAF not in map(room_of, own(path)) or named(path) == "__init__.py"


def test_every_floor_is_one_of_a_room() -> None:
    assert set(FLOOR) == {room_of(m) for m in FILES}


def test_no_file_imports_itself_round_a_circle() -> None:
    """Also inside a room, and also by imports that functions make when they run."""
    todo = dict.fromkeys(FILES)
    while todo:
        free = [m for m in todo if not own(FILES[m]) & set(todo)]
        assert free, f"circle among {sorted(todo)}"
        for m in free:
            del todo[m]


@of_every_module
def test_what_is_imported_late_is_named_where_it_is(path: Path) -> None:
    """``lazy("intarsia.patches.patch_synthesis")``: a name that is put together hides the file from tools."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "lazy":
            assert all(isinstance(a, ast.Constant) for a in node.args)
            assert not str(node.args[0].value).startswith("intarsia") or str(node.args[0].value)[9:] in {
                *FILES, *(m.removesuffix(".__init__") for m in FILES)
            }  # fmt: skip


@of_every_module
def test_every_library_has_its_home(path: Path) -> None:
    for parts in imports(path):
        assert package_of(path) in HOMES.get(parts[0], {package_of(path)}), f"{parts[0]} in {named(path)}"
        assert parts[0] != "numba" or is_kernel(path), f"numba in {named(path)}"


@pytest.mark.parametrize("path", [p for p in modules() if p.stem.endswith("_kernels")], ids=named)
def test_kernels_of_a_room_use_its_own_and_the_shared_ones_alone(path: Path) -> None:
    """What else they call would not be in the digest that compiled kernels are kept by."""
    for other in own(path):
        mine = is_kernel(FILES[other]) and room_of(name_of(path)) in (LEAF, room_of(other))  # the leaf stands on all
        assert mine or room_of(other) == "kernels" or other in SHARED, f"{named(path)} imports {other}"
    assert {p[3] for p in imports(path) if p[:3] == ("intarsia", "foundation", "arrays")} <= TYPES
    known = {"__future__", "collections", "intarsia", "math", "numba", "numpy", "typing"}
    assert {p[0] for p in imports(path)} <= known


@pytest.mark.parametrize("room", sorted({p.parent for p in modules()}), ids=named)
def test_rooms_hand_on_no_names(room: Path) -> None:
    """An `__init__` holds what its room is about, or nothing; names are handed on only where others look."""
    if named(room).replace(".", "") not in PUBLIC:
        inside = tree(room / "__init__.py")
        names = {a.asname or a.name for n in inside.body if isinstance(n, ast.ImportFrom) for a in n.names}
        used = {n.id for n in ast.walk(inside) if isinstance(n, ast.Name)}
        assert names - {"annotations"} <= used
        assert not ({"__all__", "__getattr__"} & used)


@pytest.mark.parametrize("room", sorted({p.parent for p in modules()}), ids=named)
def test_no_name_of_a_room_is_that_of_a_file_in_it(room: Path) -> None:
    """Python puts a file, once it is imported, into the room under its name, over what stood there."""
    inside, files = tree(room / "__init__.py"), {p.stem for p in room.iterdir()} - {"__init__"}
    taken = [a for n in inside.body if isinstance(n, ast.ImportFrom) and n.module for a in n.names]
    made = {n.name for n in inside.body if isinstance(n, (ast.FunctionDef, ast.ClassDef))}
    assert named(room) in PUBLIC or not files & (made | {a.asname or a.name for a in taken})


def test_tests_lie_in_folders_named_after_rooms() -> None:
    """Beside them lie those of several rooms, or of the modules that are no room."""
    folders = {p.name for p in Path(__file__).parent.iterdir() if p.is_dir() and list(p.glob("test_*.py"))}
    assert folders <= {p.name for p in ROOT.iterdir() if p.is_dir()}


METHOD_FILES = sorted({*(ROOT / "methods").glob("*.py"), *(FILES[module] for module, _ in METHODS.values())})


@pytest.mark.parametrize("path", METHOD_FILES, ids=named)
def test_methods_do_not_import_one_another(path: Path) -> None:
    """A published one may be one of the others, with more to set."""
    others = {name_of(p) for p in METHOD_FILES} - {"methods.__init__"}
    assert not {o for o in own(path) & others if room_of(name_of(path)) != LEAF or room_of(o) == LEAF}


LIGHT = {"foundation", "methods", "model"}
"""What parameters are made of; the model for its types alone."""


def is_light(module: str) -> bool:
    """Whether a file imports parameters alone, or files beside it of which the same is true."""
    others = own(FILES[module])
    return all(room_of(o) in LIGHT or (room_of(o) == LEAF == room_of(module) and is_light(o)) for o in others)


@pytest.mark.parametrize("slug", METHODS)
def test_a_method_is_parameters_and_the_engine_that_it_names(slug: str) -> None:
    """Its file imports nothing that works; the engine has the functions that it promises, and draws nothing."""
    cls, module = method_class(slug), METHODS[slug][0]
    assert is_light(module)
    engine = cls.engine.removeprefix("intarsia.")
    functions = {n.name for n in tree(FILES[engine]).body if isinstance(n, ast.FunctionDef)}
    assert {"resolved", "synthesize", *(["window"] if Ability.WINDOW in cls.supports else [])} <= functions
    assert not {room_of(other) for other in own(FILES[engine])} & {"rendering", "files"}


def parameters(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """How many parameters a function has, without the object that it belongs to."""
    a = node.args
    given = [x.arg for x in (*a.posonlyargs, *a.args, *a.kwonlyargs)]
    return len(given) - (given[:1] in (["self"], ["cls"]))


def test_functions_take_few_parameters() -> None:
    """At most 8, a kernel 12; what takes more is listed with a reason, and only as long as it does."""
    found = {}
    for path in modules():
        most = KERNEL_PARAMETERS if is_kernel(path) else PARAMETERS
        for node in ast.walk(tree(path)):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and parameters(node) > most:
                found[node.name] = parameters(node)
    assert found == {name: number for name, (number, _) in MANY.items()}


@of_every_module
def test_files_and_functions_stay_short(path: Path) -> None:
    """At most 500 lines a file, 60 a function (90 a kernel), its docstring not counted."""
    assert len(path.read_text(encoding="utf-8").splitlines()) <= FILE_LINES
    kernels = is_kernel(path)
    for node in ast.walk(tree(path)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            first = node.body[0]
            told = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and len(node.body) > 1
            said = (first.end_lineno or 0) - first.lineno + 1 if told else 0
            lines = (node.end_lineno or 0) - node.lineno + 1 - said
            assert lines <= (KERNEL_LINES if kernels else FUNCTION_LINES), node.name


@of_every_module
def test_a_file_names_nothing_twice(path: Path) -> None:
    """A constant that is set again means the later value above, too."""
    given = [t for n in tree(path).body if isinstance(n, ast.Assign) for one in n.targets for t in ast.walk(one)]
    names = [t.id for t in given if isinstance(t, ast.Name)]
    assert len(names) == len(set(names))


@of_every_module
def test_names_say_what_is_in_a_file(path: Path) -> None:
    assert not {"utils", "util", "core", "_shared", "shared", "common", "helpers", "misc"} & set(
        path.relative_to(ROOT).with_suffix("").parts
    )


@of_every_module
def test_every_file_begins_with_a_sentence(path: Path) -> None:
    told = ast.get_docstring(tree(path))
    assert told
    assert told.splitlines()[0].endswith((".", ":", "?"))


@of_every_module
def test_nothing_but_draws_makes_randomness(path: Path) -> None:
    """No generator, seeded or not; `secrets` is for `--seed random` alone."""
    for parts in imports(path):
        assert parts[0] != "random"
        assert parts[:2] != ("numpy", "random")
        assert parts[0] != "secrets" or package_of(path) == "request"
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Attribute) and node.attr in ("random", "default_rng"):
            assert ast.unparse(node.value) not in ("np", "numpy", "np.random", "numpy.random"), named(path)


@of_every_module
def test_kernels_never_trade_exactness_for_speed(path: Path) -> None:
    """No fastmath, no parallel loops, no `prange`: a decision never depends on the machine."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.keyword) and node.arg in ("fastmath", "parallel"):
            assert isinstance(node.value, ast.Constant)
            assert not node.value.value
        assert not (isinstance(node, ast.Name) and node.id == "prange")


@of_every_module
def test_nothing_is_read_that_can_hide_code(path: Path) -> None:
    """No pickle, no eval of files, no network."""
    banned = {"pickle", "marshal", "shelve", "urllib", "http", "socket", "requests"}
    banned -= HIDING.get(named(path), set())
    for parts in imports(path):
        assert parts[0] not in banned
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Call):
            assert ast.unparse(node.func) not in ("eval", "exec")
            for k in node.keywords:
                assert not (k.arg == "allow_pickle" and ast.unparse(k.value) != "False")


def test_no_room_grows_over_its_budget() -> None:
    found = sizes()
    assert set(found) == set(BUDGET)
    for room, size in found.items():
        assert size <= BUDGET[room], f"{room}: remove what the new code beats, or show by figures why both are needed"


def test_a_budget_counts_code_alone_and_long_lines_win_nothing() -> None:
    text = '"""Told."""\ndef twice(x):  # doubled\n    """Told, too."""\n    return f"{x * 2:.1f} px"\n'
    assert tokens(text) == tokens("def twice(x): return f'{x}'") == 8
