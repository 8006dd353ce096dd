"""A kernel and the types it is compiled for as one line of text, and back: what a list of kernels is made of.

``search.reduce_kernels.mask_keys(array(float32, 3, C), array(uint64, 1, C))``: names below the package, types as numba
calls them, arrays with their dimensions and layout; a tuple with names is written as its class.
"""

from __future__ import annotations

import ast
from importlib import import_module
from typing import Any

from numba import types
from numba.core.errors import TypingError

PACKAGE = __name__.partition(".")[0]
SCALARS = {str(t): t for t in (*types.integer_domain, *types.real_domain, *types.complex_domain, types.boolean)}

array: Any = types.Array
_tuple_of: Any = types.BaseTuple.from_types


def line_of(function: Any, signature: tuple[Any, ...]) -> str:
    """Write a kernel and the types of its arguments; ValueError for a type that no line can say."""
    return f"{_named(function)}({', '.join(map(_written, signature))})"


def compile_line(line: str) -> None:
    """Compile a kernel for the types that a line says, unless that was done.

    ValueError if it says no such thing, or types that the kernel cannot take: it may be older than the kernel.
    """
    function, signature = kernel_of(line)
    try:
        function.compile(signature)
    except TypingError as e:
        raise ValueError(f"no types of this kernel: {line}") from e


def kernel_of(line: str) -> tuple[Any, tuple[Any, ...]]:
    """Return the kernel and the types of its arguments that a line names; ValueError if it names none."""
    try:
        call = ast.parse(line, mode="eval").body
        assert isinstance(call, ast.Call)
        function, signature = _found(call.func), tuple(map(_read, call.args))
        assert callable(function.compile)
        assert function.py_func.__code__.co_argcount == len(signature)
    except (SyntaxError, AssertionError, AttributeError, ImportError, KeyError, TypeError, ValueError) as e:
        raise ValueError(f"no kernel: {line}") from e
    return function, signature


def _named(thing: Any) -> str:
    package, _, module = thing.__module__.partition(".")
    if package != PACKAGE:
        raise ValueError(f"{thing} is of another package")
    return f"{module}.{thing.__qualname__}"


def _written(known: Any) -> str:
    kind: Any = known
    if isinstance(known, types.Array) and kind.aligned:
        more = "" if kind.mutable else ", readonly"
        return f"array({_written(kind.dtype)}, {kind.ndim}, {kind.layout}{more})"
    if isinstance(known, types.BaseTuple):
        inner = ", ".join(map(_written, kind.types))
        return f"{_named(kind.instance_class)}({inner})" if isinstance(known, types.BaseNamedTuple) else f"({inner},)"
    if str(kind) not in SCALARS:
        raise ValueError(f"no line can say {kind}")
    return str(kind)


def _read(node: Any) -> Any:
    if isinstance(node, ast.Name):
        return SCALARS[node.id]
    if isinstance(node, ast.Tuple):
        return _tuple_of(tuple(map(_read, node.elts)))
    assert isinstance(node, ast.Call)
    if isinstance(node.func, ast.Name):
        dtype, ndim, layout, *more = node.args
        dimensions, order = ast.literal_eval(ndim), ast.unparse(layout)
        assert node.func.id == "array" and order in ("C", "F", "A")  # noqa: PT018
        return array(_read(dtype), dimensions, order, readonly=bool(more))
    return _tuple_of(tuple(map(_read, node.args)), _found(node.func))


def _found(node: Any) -> Any:
    module, _, name = ast.unparse(node).rpartition(".")
    return getattr(import_module(f"{PACKAGE}.{module}"), name)
