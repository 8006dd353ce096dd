"""Parameters: written once, checked, parsed and put into words from there."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from intarsia.foundation import ParameterError
from intarsia.foundation.params import AUTO, Parameter, check, extent, param, parameters, parse


@dataclass(frozen=True)
class Sample:
    """One parameter of every kind."""

    count: int = param(3, "int", "how many", low=1, high=9, unit="px")
    share: float = param(0.5, "float", "how much", low=0, high=1)
    side: Any = param(AUTO, "extent", "how long", low=1, high=100, unit="px")  # noqa: RUF009
    mode: str = param("a", "choice", "which", choices=("a", "b"))
    weights: Any = param(AUTO, "weights", "how heavy", low=0, high=10)  # noqa: RUF009
    isometries: Any = param("none", "isometries", "how turned")  # noqa: RUF009
    plain: int = 7

    def __post_init__(self) -> None:
        check(self)


def told(**values: Any) -> str:
    with pytest.raises(ParameterError) as caught:
        Sample(**values)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def kinds() -> dict[str, Parameter]:
    return {p.name: p for p in parameters(Sample)}


def test_fields_without_a_word_are_no_parameters() -> None:
    assert list(kinds()) == ["count", "share", "side", "mode", "weights", "isometries"]
    assert [p.name for p in parameters(Sample())] == list(kinds())


def test_the_entry_of_a_listing_is_json() -> None:
    entry = json.loads(json.dumps(kinds()["mode"].as_dict()))
    assert entry == {
        "name": "mode", "kind": "choice", "default": "a", "low": None, "high": None, "unit": "",
        "choices": ["a", "b"], "help": "which",
    }  # fmt: skip


def test_good_values_get_their_normal_form() -> None:
    s = Sample(count=4.0, share=1, side=(8, 8), weights=[1, 2.5], isometries=[6, 0, 6])
    assert (s.count, s.share, s.side, s.weights, s.isometries) == (4, 1.0, 8, (1.0, 2.5), (0, 6))
    assert isinstance(s.count, int)
    assert isinstance(s.share, float)
    assert Sample(side=[3, 5]).side == (3, 5)
    assert Sample(isometries="both").isometries == "both"
    assert Sample().side is None


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"count": 0}, "count=0 is not allowed; give 1 to 9 px."),
        ({"count": 2.5}, "count=2.5 is not allowed; give 1 to 9 px."),
        ({"count": True}, "count=True is not allowed"),
        ({"count": "3"}, "count=3 is not allowed"),
        ({"count": None}, "count=None is not allowed"),
        ({"count": math.inf}, "count=inf is not allowed"),
        ({"share": -0.1}, "share=-0.1 is not allowed; give 0 to 1."),
        ({"share": math.nan}, "share=nan is not allowed"),
        ({"side": (3, 200)}, "side=200x3 is not allowed; give 1 to 100 px, one number or WIDTHxHEIGHT."),
        ({"side": (1, 2, 3)}, "side=3x2x1 is not allowed"),
        ({"side": 0}, "side=0 is not allowed"),
        ({"mode": "c"}, "mode=c is not allowed; give one of a, b."),
        ({"weights": (0, 0)}, "weights=(0, 0) is not allowed; give 0 to 10, one for each channel."),
        ({"weights": ()}, "weights=() is not allowed"),
        ({"weights": 3}, "weights=3 is not allowed"),
        ({"isometries": "45"}, "isometries=45 is not allowed; give none, 180, 90, both, auto, or isometry numbers"),
        ({"isometries": (8,)}, "isometries=(8,) is not allowed"),
        ({"isometries": ()}, "isometries=() is not allowed"),
    ],
)
def test_bad_values_are_refused_in_one_line(values: dict[str, Any], message: str) -> None:
    assert told(**values).startswith(message)


@pytest.mark.parametrize(("name", "text", "value"), [
    ("count", "3", 3), ("share", "0.25", 0.25), ("side", "12", 12), ("side", "30x20", (20, 30)),
    ("side", "30X20", (20, 30)), ("mode", "b", "b"), ("weights", "1,2.5,0", (1.0, 2.5, 0.0)),
    ("isometries", "both", "both"), ("isometries", "180", "180"), ("isometries", "0,5", (0, 5)),
])  # fmt: skip
def test_text_is_read_as_the_command_line_writes_it(name: str, text: str, value: Any) -> None:
    """Extents stand width before height in text, height before width in Python."""
    assert parse(kinds()[name], text) == value


@pytest.mark.parametrize(
    ("name", "text"),
    [("count", "3.5"), ("count", ""), ("share", "a"), ("side", "3x"), ("weights", "1,,2"), ("isometries", "0,x")],
)
def test_text_that_is_no_value_is_refused(name: str, text: str) -> None:
    with pytest.raises(ParameterError, match="is not allowed; give") as caught:
        parse(kinds()[name], text)
    assert "\n" not in str(caught.value)


@given(st.integers(1, 9), st.floats(0, 1), st.integers(1, 100), st.integers(1, 100))
def test_what_is_written_is_read_again(count: int, share: float, rows: int, columns: int) -> None:
    """Every parameter survives being written as text."""
    p = kinds()
    assert parse(p["count"], str(count)) == count
    assert parse(p["share"], repr(share)) == share
    s = Sample(side=parse(p["side"], f"{columns}x{rows}"))
    assert extent(s.side) == (rows, columns)
    assert extent(rows) == (rows, rows)


def test_vectors_are_read_as_pairs() -> None:
    p = Parameter(name="lattice", kind="vectors", default=AUTO, low=-99, high=99, unit="px", help="by which steps")
    assert parse(p, "20.5,0 -3,9") == ((20.5, 0.0), (-3.0, 9.0))
    with pytest.raises(ParameterError, match=r"^lattice=a,b is not allowed; give one or two vectors x,y in px"):
        parse(p, "a,b")
