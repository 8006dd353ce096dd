"""The kept list of mutations fits the package: every text is there once, and every test exists."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest
from mutants import SOURCE, TESTS, Mutant, drawn, mutants

LISTED = mutants()


@cache
def named_in(path: Path) -> set[str]:
    """The tests of a file that `make test` runs, as pytest names them."""
    found = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef) and not is_long(node):
            inner = [f for f in node.body if isinstance(f, ast.FunctionDef) and not is_long(f)]
            found |= {f"{node.name}::{f.name}" for f in inner}
        elif isinstance(node, ast.FunctionDef) and not is_long(node):
            found.add(node.name)
    return {name for name in found if name.split("::")[-1].startswith("test_")}


def is_long(node: ast.ClassDef | ast.FunctionDef) -> bool:
    """Whether a test as a whole is left to `make test-long`."""
    return any(ast.unparse(d) == "pytest.mark.long" for d in node.decorator_list)


@pytest.mark.parametrize("mutant", LISTED, ids=[f"{m.file}-{n}" for n, m in enumerate(LISTED)])
def test_a_mutation_changes_one_place_and_names_tests_that_exist(mutant: Mutant) -> None:
    text = (SOURCE / mutant.file).read_text(encoding="utf-8")
    assert text.count(mutant.old) == 1, "the text must be there once; where the line changed, so must the row"
    assert mutant.new != mutant.old
    if mutant.file.endswith(".py"):
        ast.parse(text.replace(mutant.old, mutant.new))
    assert mutant.rule
    assert mutant.tests
    for test in mutant.tests:
        file, _, name = test.partition("::")
        assert name.split("[")[0] in named_in(TESTS / file), test


def test_there_are_enough_of_them_and_none_twice() -> None:
    assert len(LISTED) >= 60
    assert len({(m.file, m.old, m.new) for m in LISTED}) == len(LISTED)


def test_a_share_is_drawn_by_its_seed() -> None:
    """The same again for the same seed; over many, every row has its turn."""
    assert drawn(LISTED, 10, "a") == drawn(LISTED, 10, "a")
    some = [drawn(LISTED, 10, str(n)) for n in range(200)]
    assert {len(rows) for rows in some} == {-(-len(LISTED) // 10)}
    assert {m.name for rows in some for m in rows} == {m.name for m in LISTED}
