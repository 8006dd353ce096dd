"""The list of slow tests: what it leaves out of `make test`, and that every case has its turn."""

from __future__ import annotations

from slow import ALL, ALWAYS, BUT, ONE, QUICK, TESTS, in_share, is_slow, kept, listed


def test_what_is_listed_is_left_out_and_the_rest_stays() -> None:
    slow = {"a.py::test_few": ["[x]"], "a.py::test_most": [BUT, "[x]"], "a.py::test_alone": [""]}
    cases = {"test_few[x]": True, "test_few[y]": False, "test_most[x]": False, "test_most[y[0]]": True,
             "test_alone": True, "test_new[x]": False, "test_new": False}  # fmt: skip
    assert {case: is_slow(f"a.py::{case}", slow) for case in cases} == cases


def test_quick_cases_stay_and_the_quickest_of_slow_ones() -> None:
    assert kept([(QUICK / 2, "[a]"), (QUICK * 2, "[b]")]) == ["[a]"]
    assert kept([(ONE * 0.9, "[a]"), (ONE * 0.8, "[b]")]) == ["[b]"]
    assert kept([(ONE * 2, "")]) == []
    some = kept([(QUICK / 2, f"[{n}]") for n in range(1000)])
    assert len(some) == int(ALL / QUICK * 2)
    assert some != sorted(some)


def test_every_case_is_in_one_share_and_over_many_seeds_in_each() -> None:
    assert all(in_share("a.py::test[x]", 1, seed) for seed in "abc")
    found = [sum(in_share(f"a.py::test[{n}]", 3, seed) for n in range(300)) for seed in "abcdef"]
    assert all(60 < count < 140 for count in found)
    assert any(in_share("a.py::test[x]", 3, str(seed)) for seed in range(30))


def test_what_is_named_is_there() -> None:
    """A test that was renamed is quick again until the list is written anew, but its name must not stay."""
    shared = [TESTS / "laws.py", TESTS / "search/search_contract.py", TESTS.parent / "src/intarsia/testing/contract.py"]
    inherited = "".join(path.read_text(encoding="utf-8") for path in shared)
    for test in (*listed(), *ALWAYS):
        file, *_, name = test.split("::")
        assert f"def {name}(" in (TESTS / file).read_text(encoding="utf-8") + inherited, test
