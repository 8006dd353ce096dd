"""The benchmark is complete and counts right; how fast anything is, is never tested."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
from test_docs import load

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def bench() -> ModuleType:
    return load(ROOT / "benchmarks" / "bench.py")


def test_cases_are_listed_and_told_apart(bench: ModuleType) -> None:
    functions = {name for name in vars(bench) if name.startswith("case_")}
    assert {f.__name__ for f in bench.CASES.values()} == functions
    children = {name for name in vars(bench) if name.startswith("child_")} - {"child_cpu"}
    assert {f.__name__ for f in bench.CHILDREN.values()} == children


def test_a_case_gives_results_with_units(bench: ModuleType) -> None:
    (found,) = bench.case_elements()
    assert found.value > 0
    assert found.unit == "R"
    assert found.met is None


def test_targets_are_judged_and_tables_show_every_result(bench: ModuleType) -> None:
    assert [bench.Result("a", n, "R", 2.0).met for n in (1.0, 3.0, None)] == [True, False, None]
    results = [bench.Result("first", 1.234, "R", 5, "9 ms"), bench.Result("second", None, "x", None, "load 3.0")]
    assert "not measured" in bench.table(results)
    assert bench.markdown(results).count("\n") == 3
    assert "1.23 R" in bench.markdown(results)


def test_pieces_are_laid_out_on_cores_as_threads_take_them(monkeypatch: pytest.MonkeyPatch) -> None:
    more = load(ROOT / "benchmarks" / "more_cores.py")
    assert more.makespan([3.0, 1.0, 1.0, 2.0], 2) == pytest.approx(4 + more.WAKE)
    assert more.makespan([3.0], 8) == 3.0
    assert more.makespan([], 8) == 0.0
    clock = [0.0]
    monkeypatch.setattr(more.time, "process_time", lambda: clock[0])

    def piece(seconds: object) -> float:
        if isinstance(seconds, list):
            return sum(pools.each(piece, seconds))
        clock[0] += float(str(seconds))
        return float(str(seconds))

    pools = more.Pools(2)
    assert pools.each(piece, [4.0, [3.0, 3.0], 2.0]) == [4.0, 6.0, 2.0]
    assert pools.saved == [pytest.approx(12 - 5 - 2 * more.WAKE)]  # 4 beside 3 (two at once) and then 2


def test_wall_times_are_left_out_on_a_busy_machine(bench: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench.os, "getloadavg", lambda: (3.0, 3.0, 3.0), raising=False)
    found = bench.case_threads()
    assert len(found) == 6
    assert {row.value for row in found} == {None}


def test_results_are_kept_as_json(
    bench: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bench, "RESULTS", tmp_path / "bench" / "results.json")
    monkeypatch.setattr(bench, "CASES", {"one": lambda: [bench.Result("one", 1.0, "R", 2.0)]})
    monkeypatch.setattr(sys, "argv", ["bench.py"])
    bench.main()
    kept = json.loads((tmp_path / "bench" / "results.json").read_text())
    assert kept["results"][0]["name"] == "one"
    assert not re.search(r"node|host|user", json.dumps(kept["machine"]))
    assert "one" in capsys.readouterr().out


def test_the_table_of_source_000_follows_from_its_results_and_is_that_of_the_page(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    source = load(ROOT / "benchmarks" / "source_000.py")
    names = [task.name for task in source.TASKS]
    assert len(set(names)) == len(names)
    first = source.Result(names[0], 3.0, "R", None, "", 0.125)
    lines = source.table([first]).splitlines()
    assert len(lines) == 2 + len(names)
    assert lines[2].endswith("| 0.125 | 3.00 |")
    assert all("not measured" in line for line in lines[3:])
    text = (ROOT / "docs" / "sources-000.md").read_text(encoding="utf-8").partition("## Timings")[2]
    told = re.findall(r"^(\| \d+x\d+ \| .* \| )\d+\.\d+ \| \d+\.\d+ \|$", text, re.MULTILINE)
    rows = {f"| {' | '.join(task.sizes)} | {task.reported} | {task.seconds} | " for task in source.TASKS}
    assert len(told) == 12
    assert rows >= set(told)
