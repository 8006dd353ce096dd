"""Numbers that decide something say where they come from: a paper, an experiment, or what they are by definition."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from house import ROOT, named, tree

ROOMS = (
    "regular/*.py", "lattice/*.py", "choosing/*.py", "segments/*.py", "seams/__init__.py", "seams/energy_kernels.py",
    "seams/worst_seams.py", "analysis/defect_rim.py", "analysis/symmetry.py", "analysis/elements.py",
    "analysis/saliency.py", "analysis/illumination.py", "patches/repetition_kernels.py", "corrections/stack.py",
    "corrections/coordinate_pyramid.py", "corrections/advected.py", "corrections/appearance.py", "corrections/guide.py",
    "corrections/span.py", "corrections/parallel_controllable.py",
)  # fmt: skip
PLACES = sorted(path for pattern in ROOMS for path in ROOT.glob(pattern))


def is_number(node: ast.expr | None) -> bool:
    """Whether an expression is numbers and nothing else: 3, -1.5, 1 << 16, (2, 0.5), {2: 0.5}, FACE // 3."""
    if node is None or isinstance(node, ast.Name):
        return False
    parts = [part for part in ast.walk(node) if isinstance(part, ast.expr)]
    allowed = (ast.Constant, ast.Name, ast.UnaryOp, ast.BinOp, ast.Tuple, ast.List, ast.Dict, ast.Set)
    values = [part.value for part in parts if isinstance(part, ast.Constant)]
    numbers = [value for value in values if isinstance(value, (int, float)) and not isinstance(value, bool)]
    return bool(numbers) and len(numbers) == len(values) and all(isinstance(part, allowed) for part in parts)


def numbers_in(body: list[ast.stmt]) -> list[int]:
    """Where in a body numbers get a name."""
    return [k for k, n in enumerate(body) if isinstance(n, (ast.Assign, ast.AnnAssign)) and is_number(n.value)]


def has_origin(lines: list[str], body: list[ast.stmt], k: int) -> bool:
    """Whether a comment stands on the lines of a statement or right above, or a string right below it."""
    node = body[k]
    assert node.end_lineno is not None
    own = lines[node.lineno - 1 : node.end_lineno]
    after = body[k + 1] if k + 1 < len(body) else None
    told = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) and isinstance(after.value.value, str)
    return told or any("  # " in line for line in own) or lines[node.lineno - 2].lstrip().startswith("# ")


def is_table(node: ast.ClassDef) -> bool:
    """Whether a class is a table of numbers: a named tuple, or what only gives names to values."""
    named = any(getattr(base, "id", "") == "NamedTuple" for base in node.bases)
    plain = not (node.bases or node.decorator_list or any(isinstance(n, ast.FunctionDef) for n in node.body))
    return named or plain


def without_origin(lines: list[str], module: ast.Module) -> list[str]:
    """The lines of numbers, at the top of a module and in its tables, of which nothing is said."""
    found = []
    tables = [node.body for node in module.body if isinstance(node, ast.ClassDef) and is_table(node)]
    for body in (module.body, *tables):
        found += [lines[body[k].lineno - 1] for k in numbers_in(body) if not has_origin(lines, body, k)]
    return found


@pytest.mark.parametrize("path", PLACES, ids=named)
def test_every_number_says_where_it_comes_from(path: Path) -> None:
    assert not without_origin(path.read_text(encoding="utf-8").splitlines(), tree(path))


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("LEAST = 0.05  # of 50 photographs", 0),
        ("# Of 50 photographs.\nLEAST = 0.05", 0),
        ('LEAST = 0.05\n"""Of 50 photographs."""', 0),
        ("LEAST = 0.05", 1),
        ("LOW, HIGH = 1, -2.5", 1),
        ("FEW = {2: 0.5}", 1),
        ("SIDE = 1 << 9", 1),
        ('NAME = "rows"', 0),
        ("class Costs(NamedTuple):\n    turn: int = 100\n    near: int = 5  # of 16 walls", 1),
        ("class Costs:\n    turn = 100\n    near = 5  # of 16 walls", 1),
        ("@dataclass\nclass Other:\n    turn: int = 100", 0),
        ("class Other:\n    turn = 100\n    def near(self): ...", 0),
    ],
)
def test_numbers_without_a_word_are_found(text: str, missing: int) -> None:
    assert len(without_origin(text.splitlines(), ast.parse(text))) == missing
