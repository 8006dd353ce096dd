"""Parameters that are numbers, words or gray pictures: read as they stand behind an option. Imports nothing heavy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..errors import InputError, ParameterError
from ..params import OVER, Parameter, parse
from .fields import parameters_of

if TYPE_CHECKING:
    from ..field import Field


def value_of(p: Parameter, text: str) -> Any:
    """Read a value behind an option; the name of a picture stays one."""
    return text if names_a_picture(p, text) else parse(p, text)


def names_a_picture(p: Parameter, text: Any) -> bool:
    """Whether a value is the name of a file: whatever is neither a number nor a word of the parameter."""
    if p.kind not in OVER or not isinstance(text, str) or text in p.choices:
        return False
    try:
        float(text)
    except ValueError:
        return True
    return False


def picture_of(p: Parameter, path: str) -> Field:
    """Read a gray picture of any depth as a field of a parameter; InputError where it is none."""
    import numpy as np

    from .. import files
    from ..field import Field
    from ..image import Kind

    if not path or "\0" in path:
        raise InputError(f"{p.name}: {path!r} is no name of a file; choose another.")
    plane = files.read_plane(path, Kind.DATA)
    pixels, name = plane.samples, "stdin" if path == "-" else path
    if plane.channels in (2, 4):
        if (pixels[:, :, -1] != pixels[0, 0, -1]).any():
            raise InputError(f"{name} is transparent in parts; {p.name} takes a gray picture without opacity.")
        pixels = pixels[:, :, :-1]
    if not all(np.array_equal(pixels[:, :, 0], pixels[:, :, c], equal_nan=True) for c in range(1, pixels.shape[2])):
        raise InputError(f"{name} is a colour picture; {p.name} takes a gray one.")
    try:
        return Field(pixels[:, :, 0], p.low, p.high)
    except InputError as e:
        raise InputError(f"{p.name}: of {name}, {e}") from None


def asked_pictures(recipe: dict[str, Any]) -> dict[str, Any]:
    """What a recipe says of parameters that were pictures, by their names: it knows them by their hashes."""
    known, values = parameters_of(recipe.get("method")), recipe.get("parameters")
    recorded = {k: v for k, v in values.items() if isinstance(v, dict)} if isinstance(values, dict) else {}
    return {k: v for k, v in recorded.items() if k in known and known[k].kind in OVER}


def with_pictures(recipe: dict[str, Any], pictures: Mapping[str, str], name: str) -> dict[str, Any]:
    """Return the recipe of `name` with the pictures that it knows by their hashes, read again from their files."""
    values, asked, known = recipe.get("parameters"), asked_pictures(recipe), parameters_of(recipe.get("method"))
    for given in pictures:
        if given not in asked:
            raise ParameterError(f"{name} was made without a picture as {given}; drop --picture {given}=FILE.")
    found: dict[str, Any] = {}
    for key, was in asked.items():
        if "function" in was:
            told_by = f"{key} of {name} is the function {was['function']}"
            raise InputError(f"{told_by}, which no recipe holds; run the program again that made it.")
        if key not in pictures:
            raise ParameterError(f"{name} was made with a picture as {key}; name it with --picture {key}=FILE.")
        found[key] = picture_of(known[key], pictures[key])
        if found[key].as_recipe != was:
            raise InputError(f"{pictures[key]} is another picture than the recipe has as {key}; give the same file.")
    return recipe | {"parameters": values | found} if found and isinstance(values, dict) else recipe
