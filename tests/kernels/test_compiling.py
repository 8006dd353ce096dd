"""How kernels are compiled: once for each use, machine code only where Python calls, numba's own ways left alone."""

from __future__ import annotations

import gc
import operator
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import event
from numba.core.registry import cpu_target

from intarsia.kernels import compiling
from intarsia.kernels.compiling import Kernel, KernelCache


def kernel(function: Any, folder: Path | None = None) -> Any:
    """A kernel of its own, kept in a folder."""
    compiled: Any = Kernel(function)
    compiled._cache = KernelCache(function, lambda: folder and str(folder))
    return compiled


def pair(folder: Path | None = None) -> tuple[Any, Any]:
    """A kernel, and one that calls it, with a number that is written there and with one that is not."""

    def added(values: Any, more: int) -> Any:
        out = np.empty(len(values), np.int64)
        for k in range(len(values)):
            out[k] = values[k] + more
        return out

    inner = kernel(added, folder)

    def twice_added(values: Any, more: int) -> Any:
        return inner(inner(values, 5), more)

    return inner, kernel(twice_added, folder)


VALUES = np.arange(4)


def test_a_kernel_that_only_kernels_call_is_not_kept_and_has_no_entry(tmp_path: Path) -> None:
    inner, outer = pair(tmp_path)
    assert outer(VALUES, 7).tolist() == [12, 13, 14, 15]
    assert [path.name.split("-")[0] for path in tmp_path.iterdir()] == ["test_compiling.pair.locals.twice_added"]
    (compiled,) = inner.overloads.values()
    assert not compiled.library._finalized


def test_a_kernel_that_python_calls_later_is_opened_and_kept_without_being_lowered_again(tmp_path: Path) -> None:
    inner, outer = pair(tmp_path)
    outer(VALUES, 7)
    with event.install_recorder("numba:compile") as lowered:
        assert inner(VALUES, 7).tolist() == [7, 8, 9, 10]
    assert not [e for _, e in lowered.buffer if e.is_start]
    assert len(list(tmp_path.iterdir())) == 2
    assert outer(VALUES, 7).tolist() == [12, 13, 14, 15]
    assert inner(VALUES.astype(np.uint8), 7).tolist() == [7, 8, 9, 10]  # other types, compiled for Python at once


def test_a_written_number_is_no_type_of_its_own() -> None:
    inner, outer = pair()
    outer(VALUES, 7)
    assert len(inner.overloads) == 1


@pytest.mark.parametrize("order", ["cheapest accumulate", "accumulate cheapest"])
def test_kernels_are_loaded_in_any_order_whichever_was_compiled_first(order: str, tmp_path: Path) -> None:
    """What one holds of the other is not taken for the other itself: arrays come back whole."""
    script = (
        "import sys, numpy as np\nfrom intarsia.kernels import shortest_paths as paths\n"
        "cost = np.arange(12).reshape(3, 4)\ngiven = {'cheapest': (cost,), 'accumulate': (cost, 0)}\n"
        "print([getattr(paths, name)(*given[name]).tolist() for name in sys.argv[1:]])"
    )

    def said(*names: str) -> str:
        command, around = [sys.executable, "-c", script, *names], {**os.environ, "INTARSIA_CACHE": str(tmp_path)}
        return subprocess.run(command, env=around, check=True, stdout=subprocess.PIPE, text=True).stdout

    names = order.split()
    right = said(*names)
    assert said(*names) == right
    assert said(*reversed(names)) == f"{list(reversed(eval(right)))}\n"


def test_numba_is_left_as_it_was_also_where_a_kernel_cannot_be_compiled() -> None:
    def untouched() -> bool:
        changed = vars(cpu_target.target_context.codegen()), vars(numba.types.Function)
        return gc.isenabled() and "_library_class" not in changed[0] and "get_call_type" not in changed[1]

    with pytest.raises(numba.errors.TypingError):
        kernel(lambda a: a.nothing_of_the_kind)(VALUES)
    assert untouched()
    pair()[1](VALUES, 7)
    assert untouched()


def test_what_a_call_of_numba_is_is_asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    plain: Any = compiling._asked
    monkeypatch.setattr(compiling, "_asked", lambda *what: asked.append(what[0].typing_key) or plain(*what))
    monkeypatch.setattr(compiling, "_answers", {})
    assert kernel(lambda a, b: (a - b) * (b - a) * (a - 2.5 * b))(3.0, 1.0) == -2.0
    assert asked.count(operator.sub) == 1
    assert asked.count(operator.mul) == 1


@pytest.mark.long
def test_no_kernel_divides_by_0_in_what_warms_up(tmp_path: Path) -> None:
    script = """if True:
    import sys
    from intarsia.kernels import compiling
    compiling.OPTIONS["error_model"] = "python"  # which raises where one does
    from intarsia.__main__ import main
    sys.argv = ["intarsia", "warm-up", "--quiet"]
    main()
    """
    around = {**os.environ, "INTARSIA_CACHE": str(tmp_path)}
    subprocess.run([sys.executable, "-c", script], env=around, check=True)
    assert any(tmp_path.rglob("*.kernel"))


def test_functions_of_others_can_use_what_kernels_use_and_the_kernels_themselves() -> None:
    inner, outer = pair()
    outer(VALUES, 7)

    @numba.njit
    def theirs(values: Any) -> Any:
        return np.empty(3, np.int64).size + outer(values, 1)[0] + inner(values, 2)[1]

    assert theirs(VALUES) == 3 + 6 + 3


def test_a_kernel_may_call_itself() -> None:
    def falling(n: int) -> int:
        return 1 if n < 2 else n * falling(n - 1)

    falling = kernel(falling)
    assert falling(5) == 120
