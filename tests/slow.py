"""Which cases of which tests `make test` leaves to `make test-slow`, by how long they take.

    python tests/slow.py report.xml      writes slow.toml from a report that pytest made of all tests (--junitxml)

Of every test the cases stay that take less than QUICK; of one that has none of these the quickest, if it takes less
than ONE; and of these, drawn by their names, so many as take ALL together. A test that is not in the list stays: it is
new. What is slow is no less tried: all by `make test-slow`, and a share, drawn by the commit, with every change.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

TESTS = Path(__file__).resolve().parent
LIST = TESTS / "slow.toml"
QUICK, ONE, ALL = 0.35, 1.5, 8.0  # s, on a machine whose cores two others share
ALWAYS = (  # whatever they take: each goes through all of the house, or says what must not change unseen
    "test_golden.py::test_maps_are_what_they_were",
    "studio/test_page_endless.py::test_panning_shows_what_lies_there",
    "studio/test_page_grow.py::test_a_sample_is_opened_and_one_button_grows_it",
    "studio/test_page_lit.py::test_tiles_are_lit_together",
    "studio/test_page_look.py::test_the_pointer_shows_where_a_pixel_came_from",
    "studio/test_page_mend.py::test_what_is_brushed_over_is_healed",
    "studio/test_page_paint.py::test_a_painting_is_grown",
)
BUT = "all but"


def listed() -> dict[str, list[str]]:
    """The tests that have slow cases, and these cases; after BUT those that are not."""
    with LIST.open("rb") as file:
        return dict(tomllib.load(file))


def is_slow(nodeid: str, slow: dict[str, list[str]]) -> bool:
    """Whether a case, ``cli/test_cli.py::test_name[case]``, is left out."""
    test, bracket, case = nodeid.partition("[")
    cases = slow.get(test, [])
    return (bracket + case in cases) != (BUT in cases)


def in_share(nodeid: str, share: int, seed: str) -> bool:
    """Whether a case belongs to one of so many equal parts, by a seed: over many seeds each as often."""
    return int(hashlib.sha256(f"{seed} {nodeid}".encode()).hexdigest(), 16) % share == 0


def measured(report: Path) -> Iterator[tuple[str, str, float]]:
    """The tests of a report, their cases, and how long each took, s."""
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        parts = case.get("classname", "").split(".")
        places = [TESTS.parent.joinpath(*parts[: n + 1]).with_suffix(".py") for n in range(len(parts))]
        count = 1 + max(n for n, path in enumerate(places) if path.is_file())  # what follows is a class
        test, bracket, name = case.get("name", "").partition("[")
        file = "/".join(parts[1:count]) + ".py"
        yield "::".join([file, *parts[count:], test]), bracket + name, float(case.get("time", 0))


def kept(cases: list[tuple[float, str]]) -> list[str]:
    """The cases of one test that are quick, of (seconds, case)."""
    some = [one for one in cases if one[0] < QUICK] or [one for one in [min(cases)] if one[0] < ONE]
    some.sort(key=lambda one: hashlib.sha256(one[1].encode()).digest())
    return [case for n, (_, case) in enumerate(some) if sum(time for time, _ in some[: n + 1]) < ALL]


def main() -> None:
    cases = defaultdict[str, list[tuple[float, str]]](list)
    for test, case, time in measured(Path(sys.argv[1])):
        cases[test].append((time, case))
    lines = ["# Written by slow.py: tests that have slow cases, and these.\n"]
    for test, each in sorted(cases.items()):
        quick = kept(each)
        slow = [case for _, case in each if case not in quick]
        if slow and not test.startswith(ALWAYS):
            lines.append(f"{json.dumps(test)} = {json.dumps(min(slow, [BUT, *quick], key=len))}\n")
    LIST.write_text("".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
