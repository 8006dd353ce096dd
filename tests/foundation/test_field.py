"""Fields: a number for every pixel, from numbers, gray pictures and functions; and parameters that take them."""

from __future__ import annotations

import json
import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import intarsia as ia
from intarsia.foundation.field import Field
from intarsia.foundation.params import AUTO, check, check_sizes, param, parameters, parse
from intarsia.methods import recipe_settings


@dataclass(frozen=True)
class Painted:
    """A parameter over the output, one over the exemplar that may also be a word."""

    slug = "painted"
    share: Any = param(AUTO, "field", "how much", low=0, high=2, over="output")  # noqa: RUF009
    ground: Any = param(AUTO, "field", "what it is", low=0, high=1, over="exemplar", choices=("edges",))  # noqa: RUF009

    def __post_init__(self) -> None:
        check(self)


def waves(y: Any, x: Any) -> Any:
    return (y + 2 * x) % 64 / 64


def flat(y: Any, x: Any) -> Any:
    return 0.25


def at(*places: int) -> Any:
    return np.array(places, np.int64)


GRAY = np.arange(12, dtype=np.uint8).reshape(3, 4) * 5


@pytest.mark.parametrize(
    ("dtype", "full"), [("uint8", 255), ("uint16", 65535), ("bool", 1)],
)  # fmt: skip
def test_whole_numbers_are_stretched_from_low_to_high(dtype: str, full: int) -> None:
    picture = np.array([[0, full], [full, 0]]).astype(dtype)
    assert Field(picture).at(at(0, 1), at(0, 1)).tolist() == [[0, 1], [1, 0]]
    assert Field(picture, -2, 6).at(at(0, 1), at(0, 1)).tolist() == [[-2, 6], [6, -2]]
    assert Painted(picture).share.at(at(0), at(0, 1)).tolist() == [[0, 2]]
    assert Painted(Field(picture, 0.5, 1)).share.at(at(0), at(0, 1)).tolist() == [[0.5, 1]]


@pytest.mark.parametrize("dtype", ["float16", "float32", "float64", "int64"])
def test_other_numbers_are_taken_as_they_are(dtype: str) -> None:
    picture = np.array([[0, 1], [2, 0]]).astype(dtype)
    got = Painted(picture).share.at(at(0, 1), at(0, 1))
    assert got.dtype == np.float64
    assert got.tolist() == [[0, 1], [2, 0]]


def test_the_border_goes_on_at_any_distance() -> None:
    got = Field(GRAY).at(at(-(2**40), 0, 1, 2, 2**40), at(-1, 0, 3, 4))
    clamped = (GRAY / 255)[[0, 0, 1, 2, 2]][:, [0, 0, 3, 3]]
    assert (got == clamped).all()


def test_functions_are_asked_for_rows_and_columns() -> None:
    rows, columns = at(-5, 2**40), at(1, 2, 3)
    assert Field(waves).at(rows, columns).tolist() == [[(y + 2 * x) % 64 / 64 for x in (1, 2, 3)] for y in (-5, 2**40)]
    assert Field(flat).at(rows, columns).tolist() == [[0.25] * 3] * 2
    assert Painted(0.5).share == Painted(Field(0.5)).share == Painted(np.float32(0.5)).share == 0.5


def test_fields_are_compared_by_what_they_hold() -> None:
    deep = GRAY.astype(np.uint16) * 257
    same = [Field(GRAY), Field(deep), Field(GRAY / 255.0), Field(GRAY.copy()[:, :, None])]
    assert len({*same}) == 1
    assert all(f.as_recipe == same[0].as_recipe for f in same)
    other = [Field(GRAY, 0, 2), Field(GRAY.T), Field(GRAY + 1), Field(0.5), Field(waves), Field(flat), Field(0.25)]
    assert len({*same, *other}) == 8
    assert Field(GRAY) != GRAY.tobytes()
    for f in (*same, *other):
        again = pickle.loads(pickle.dumps(f))
        assert again == f
        assert hash(again) == hash(f)
        assert (again.at(at(0, 2), at(1)) == f.at(at(0, 2), at(1))).all()


def test_a_field_keeps_its_own_picture() -> None:
    picture = GRAY.copy()
    field = Field(picture)
    before = field.at(at(0, 1), at(0, 1))
    picture[:] = 0
    assert (field.at(at(0, 1), at(0, 1)) == before).all()
    for f in (field, pickle.loads(pickle.dumps(field))):
        with pytest.raises(ValueError, match="read-only"):
            f.value[0, 0] = 1


def test_recipes_hold_what_fields_are_known_by() -> None:
    told = recipe_settings(Painted(GRAY, "edges"))  # type: ignore[arg-type]
    assert told["share"]["size"] == [4, 3]
    assert len(told["share"]["sha256"]) == 64
    assert told["ground"] == "edges"
    assert json.loads(json.dumps(told)) == told
    assert recipe_settings(Painted(waves))["share"]["function"].endswith("test_field.waves")  # type: ignore[arg-type]
    assert recipe_settings(Painted(1))["share"] == 1.0  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (3, "share=3 is not allowed; give 0 to 2, or a gray picture over the output."),
        (True, "share=True is not allowed"),
        (float("nan"), "share=nan is not allowed"),
        ("edges", "share=edges is not allowed"),
        (np.zeros((2, 2, 3)), r"share: an array of shape \(2, 2, 3\) is no field; give a gray picture"),
        (np.zeros((0, 4)), r"share: an array of shape \(0, 4\) is no field"),
        (np.zeros(4), r"share: an array of shape \(4,\) is no field"),
        (np.array([[0.5, np.nan]]), "share: it holds NaN or infinite numbers"),
        (np.array([[0.5, np.inf]]), "share: it holds NaN or infinite numbers"),
        (np.array([[0.5, -3]]), "share: it holds numbers from -3 to 0.5; give 0 to 2."),
        (Field(GRAY, 0, 3), "share: the field goes from 0 to 3, 0 to 2 is allowed."),
        (np.array([["a"]]), "share: ndarray is no field"),
        ({"a": 1}, "share: dict is no field; give a number, a gray picture or a function."),
        (lambda y: y, "share: the function .* gives no numbers for rows"),
        (lambda y, x: "x", "share: the function .* gives no numbers"),
    ],
)  # fmt: skip
def test_what_is_no_field_is_refused_in_one_line(value: Any, message: str) -> None:
    with pytest.raises((ia.ParameterError, ia.InputError), match=f"^{message}") as caught:
        Painted(value)
    assert "\n" not in str(caught.value)


def test_a_function_is_held_to_its_range_where_it_is_asked() -> None:
    field = Painted(lambda y, x: y / 100 + 0 * x).share
    assert field.at(at(0, 200), at(0)).tolist() == [[0], [2]]
    assert field.at(at(-50, 201), at(0)).tolist() == [[0], [2]], "it is asked beside the output, too"
    assert field.at(at(-50, 201), at(0), around=True).tolist() == [[-0.5], [2.01]]
    with pytest.raises(ia.InputError, match="gives NaN"):
        Painted(lambda y, x: np.where(y > 9, np.nan, 1) + 0 * x).share.at(at(10), at(0))


def test_pictures_must_lie_on_what_they_are_for() -> None:
    method = Painted(np.zeros((6, 8)), np.zeros((3, 4)))
    check_sizes(method, (3, 4), (6, 8))
    check_sizes(method, (3, 4), None)
    with pytest.raises(ia.InputError, match=r"^the picture share is 8x6 px, the output 9x6; make them equal\.$"):
        check_sizes(method, (3, 4), (6, 9))
    with pytest.raises(ia.InputError, match=r"^the picture ground is 4x3 px, the exemplar 4x4; make them equal\.$"):
        check_sizes(method, (4, 4), None)
    check_sizes(Painted(waves, "edges"), (1, 1), (1, 1))  # type: ignore[arg-type]


def test_words_and_numbers_are_read_from_text() -> None:
    share, ground = parameters(Painted)
    assert (parse(share, "0.5"), parse(ground, "edges"), parse(ground, "1")) == (0.5, "edges", 1.0)
    assert ground.allowed() == "edges, 0 to 1, or a gray picture over the exemplar"
    assert (share.as_dict()["over"], ground.as_dict()["choices"]) == ("output", ["edges"])
    with pytest.raises(ia.ParameterError, match=r"^share=map.png is not allowed; give 0 to 2, or a gray picture"):
        parse(share, "map.png")
