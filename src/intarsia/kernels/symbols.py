"""The names that machine code asks of others: one that nobody knows would end the process that loads it."""

from __future__ import annotations

from typing import Any

from llvmlite.binding import address_of_symbol


def asked_of_others(module: Any) -> tuple[str, ...]:
    """Return the names that machine code needs and does not hold."""
    named = (*module.functions, *module.global_variables)
    return tuple(n.name for n in named if n.is_declaration and not n.name.startswith("llvm."))


def all_known(names: tuple[str, ...], target_context: Any) -> bool:
    """Tell whether all names can be found: in what was compiled or loaded here, or among what numba has made known."""
    engine = target_context.codegen()._engine
    return all(engine.is_symbol_defined(name) or address_of_symbol(name) for name in names)
