"""Compilation of kernels: once for each signature, and machine code only for kernels that Python calls.

numba makes machine code of every function that it meets, with entries for Python and for C, and does it once more
within each caller. Here, called kernels are kept as optimised LLVM modules; machine code is made where they are
linked into the kernel that Python calls, and they get an entry for Python only if they are called from there.

This depends on the internals of one version of numba. With any other, :mod:`.jit` uses its public interface.
"""

from __future__ import annotations

import gc
import hashlib
import os
import pickle
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numba
from llvmlite.binding import (
    Linkage,
    address_of_symbol,
    create_pass_builder,
    create_pipeline_tuning_options,
    parse_bitcode,
)
from numba.core import caching, environment, serialize
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.runtime import nrt

from . import DAMAGED, Unfit, cache_folder, compilation_begins, drop, not_kept, read_entry, say, write_entry

KNOWN = "0.68."
if not numba.__version__.startswith(KNOWN):
    raise ImportError(f"the inside of numba {KNOWN}x is known, not that of {numba.__version__}")

types: Any = numba.types
_asked: Any = types.functions.BaseFunction.get_call_type
_key_of: Any = caching.FunctionCache._index_key

# no kernel divides by 0, by a test; an error made ready at every divisor takes longer to compile
OPTIONS = {"nopython": True, "nogil": True, "boundscheck": None, "no_cfunc_wrapper": True, "error_model": "numpy"}
FORM = 2  # of entries
INLINED = 6000  # bytes of bitcode, 2300 of them empty: larger modules are not inlined, and are optimised by themselves


class _NoEnvironments:
    """Placeholder for the code generator of a library that has no machine code (yet)."""

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: environments are set where the library is linked."""


class Library(JITCodeLibrary):
    """Lowered functions that become machine code when an address of them is asked for, not when they are linked."""

    _codegen: Any
    _lowered: bytes | None = None  # bitcode of loaded machine code, until a kernel that calls it is compiled

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> Any:
        """Load machine code; its bitcode, which takes longer to parse, is parsed where it is linked."""
        name, machine_code, lowered, defined = state
        self: Any = codegen.create_library(name)
        self.enable_object_caching()
        self._set_compiled_object(machine_code)
        self._lowered = lowered
        self._finalize_final_module()
        codegen._engine._defined_symbols |= defined
        return self

    @property
    def codegen(self) -> Any:
        """The code generator, once there is machine code."""
        return self._codegen if self._finalized else _NoEnvironments()

    def add_ir_module(self, ir_module: Any) -> None:
        """Add a lowered module, unless it is an entry for C, which is not used."""
        if ir_module.name != "cfunc_wrapper":
            super().add_ir_module(ir_module)

    def add_linking_library(self, library: Any) -> None:
        """Add a library whose functions are called."""
        if not isinstance(library, Library):
            library._ensure_finalized()
        self._linking_libraries.append(library)

    def get_pointer_to_function(self, name: str) -> int:
        """Return the address of a function, 0 where there is none; machine code is made for it."""
        if not self._finalized and name not in {f.name for f in self._final_module.functions if not f.is_declaration}:
            return 0
        return int(super().get_pointer_to_function(name))

    def _get_module_for_linking(self) -> Any:
        if self._lowered is not None:
            self._shared_module, self._lowered = parse_bitcode(self._lowered), None
        if self._shared_module is None and not self._finalized:
            module, large = self._final_module.clone(), []
            for library in dict.fromkeys(self._linking_libraries):
                self._reload_init.update(library._reload_init)
                called = library._get_module_for_linking()
                if len(called.as_bitcode()) < INLINED:
                    module.link_in(called, preserve=True)
                else:
                    large.append(called)
            # without this less is inlined: corrections took a sixth longer
            options = create_pipeline_tuning_options(speed_level=2)
            options.loop_vectorization = options.slp_vectorization = False
            options.loop_unrolling = False  # loops unrolled here are not vectorised later: half as fast
            builder = create_pass_builder(self._codegen._tm, options)
            builder.getModulePassManager().run(module, builder)
            for called in large:
                module.link_in(called, preserve=True)
            for function in module.functions:
                if not function.is_declaration and function.linkage == Linkage.external:
                    function.linkage = "linkonce_odr"
            self._shared_module = module
        return self._shared_module or super()._get_module_for_linking()

    def _optimize_functions(self, ll_module: Any) -> None:
        """Do nothing: the whole module is optimised later."""

    def finalize(self) -> None:
        """Make machine code of this library and of all that it calls."""
        super().finalize()
        self._shared_module = None  # from now on the one that holds the entry for Python, too
        for variable in self._final_module.global_variables:
            if (found := environment.lookup_environment(variable.name)) is not None:
                self._codegen.set_env(variable.name, found)


_answers: dict[Any, Any] = {}  # (numba function, its arguments) -> type of the call, the function


def _answered(function: Any, context: Any, args: Any, kws: Any) -> Any:
    """Return the type of a call of a numba function, cached: numba tries all forms of `+` at each `+` that it meets."""
    key = id(function), args, tuple(kws.items())
    if key not in _answers:
        _answers[key] = _asked(function, context, args, kws), function
    return _answers[key][0]


_depth = 0  # of nested compilations; guarded by numba's lock


@contextmanager
def _compiling() -> Iterator[None]:
    """Compile in this context: with `Library`, cached types of calls, and without garbage collection."""
    global _depth
    with global_compiler_lock:
        codegen = cpu_target.target_context.codegen()
        collects = gc.isenabled()
        if not _depth:
            gc.disable()
            codegen._library_class = Library
            types.Function.get_call_type = _answered
        _depth += 1
        try:
            yield
        finally:
            _depth -= 1
            if not _depth:
                del codegen._library_class, types.Function.get_call_type
                if collects:
                    gc.enable()


class Kernel(CPUDispatcher):
    """A function that is compiled for each combination of types it is called with, from Python or by other kernels."""

    _compiler: Any
    _cache: Any

    def __init__(self, function: Callable[..., Any], options: dict[str, Any] | None = None) -> None:
        super().__init__(function, targetoptions=OPTIONS if options is None else options)
        self._called: dict[Any, Any] = {}  # types -> what was compiled for other kernels only
        self._compiler._customize_flags = self._flags

    def compile(self, sig: Any) -> Any:
        """Compile for a signature, unless that was done or is kept on disk."""
        given = tuple(getattr(sig, "args", sig))
        with _compiling():
            entry = super().compile(sig)
            called = self._called.pop(given, None) if _depth == 1 else None
            return entry if called is None else self._opened(sig, called)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return the template of a call from another kernel; signed integers of any width share one signature."""
        return super().get_call_template([_wide(a) for a in args], kws)

    def add_overload(self, cres: Any) -> None:
        """Register a compiled signature: for calls from Python if it has an entry, else for other kernels."""
        if cres.library.get_pointer_to_function(cres.fndesc.llvm_cpython_wrapper_name):
            super().add_overload(cres)
        else:
            self.overloads[tuple(cres.signature.args)] = self._called[tuple(cres.signature.args)] = cres

    def _compilation_chain_init_hook(self) -> None:
        """Load no extensions of numba: kernels use none, and finding them takes time."""

    def _flags(self, flags: Any) -> Any:
        compilation_begins()
        flags.no_cpython_wrapper = _depth > 1
        return flags

    def _opened(self, sig: Any, cres: Any) -> Any:
        """Add an entry for Python to a signature compiled for other kernels; return the entry."""
        context, library, fndesc = cres.target_context, cres.library, cres.fndesc
        with context.push_code_library(library):
            helper = cres.call_helper
            context.create_cpython_wrapper(library, fndesc, cres.environment, helper, release_gil=True)
            entry = context.get_executable(library, fndesc, cres.environment)
            context.insert_user_function(entry, fndesc, [library])
        opened = cres._replace(entry_point=entry)
        super().add_overload(opened)
        self._cache.save_overload(sig, opened)
        return entry


def _wide(argument: Any) -> Any:
    """Return the type with which a kernel calls another: literals have their plain type, signed integers are int64.

    Sums and products of narrow ones are int64 anyway, so that nothing else changes.
    """
    if isinstance(argument, types.BaseTuple) and not isinstance(argument, types.BaseNamedTuple):
        return types.BaseTuple.from_types([_wide(a) for a in argument])
    plain = types.unliteral(argument)
    return types.int64 if getattr(plain, "signed", False) else plain


class KernelCache:
    """Disk cache of the compiled signatures of one function, with the interface that numba's dispatcher expects."""

    def __init__(self, function: Callable[..., Any], folder: Callable[[], str | None]) -> None:
        self._py_func, self._folder = function, folder
        module = function.__module__.rpartition(".")[2]
        self._name = re.sub(r"[^\w.]", "", f"{module}.{function.__qualname__}")

    @property
    def cache_path(self) -> str | None:
        """The folder of the entries; None if none can be used."""
        return self._folder()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the function compiled for a signature, or None if there is no valid entry."""
        folder = self._folder()
        if folder is None:
            return None
        nrt.rtsys.initialize(target_context)  # sufficient for loaded machine code; numba's own refresh takes 0.2 s
        path, identity = self._entry(folder, sig, target_context.codegen())
        try:
            payload = read_entry(path, identity)
            return None if payload is None else _rebuilt(payload, target_context)
        except Unfit:
            drop(path)
            say("entry", DAMAGED.format(folder))
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store a compiled function; one that cannot be stored is compiled again in the next process."""
        folder = self._folder() if data.library._finalized else None
        if folder is None or any(not loop.can_cache for loop in data.lifted) or data.library.has_dynamic_globals:
            return
        path, identity = self._entry(folder, sig, data.codegen)
        try:
            (name, _, (machine_code, lowered)), *whole, environments = data._reduce()
            needed = tuple(e for e in environments if e.consts)  # an empty one would replace that of the kernel itself
            module = data.library._final_module
            kept = (name, machine_code, lowered, set(_names(module, False)))
            asked = tuple(n for n in _names(module, True) if not n.startswith("llvm."))
            write_entry(path, identity, serialize.dumps((asked, (kept, *whole, needed))))
        except OSError as e:
            not_kept(folder, (e.strerror or str(e)).lower())

    def _entry(self, folder: str, sig: Any, codegen: Any) -> tuple[str, bytes]:
        """Return the file of an entry, and the bytes that identify it."""
        made_by = (FORM, numba.__version__, sys.implementation.cache_tag, getattr(sys, "abiflags", ""))
        identity = repr((self._name, made_by, _key_of(self, sig, codegen))).encode()  # with types, processor, bytecode
        digest = hashlib.blake2b(identity, digest_size=12).hexdigest()
        return os.path.join(folder, f"{self._name}-{digest}.kernel"), identity


def _names(module: Any, declared: bool) -> Iterator[str]:
    """Return the names that a module defines, or, if `declared`, refers to."""
    named = (*module.functions, *module.global_variables)
    return (n.name for n in named if n.is_declaration == declared)


def _all_known(names: tuple[str, ...], target_context: Any) -> bool:
    """Return whether all symbols are defined, in the engine or in the process."""
    engine = target_context.codegen()._engine
    return all(engine.is_symbol_defined(name) or address_of_symbol(name) for name in names)


def _rebuilt(payload: bytes, target_context: Any) -> Any:
    """Return the callable function of an entry; raise Unfit if symbols are undefined, which would end the process."""
    try:
        names, whole = pickle.loads(payload)
        if not _all_known(names, target_context):
            target_context.refresh()
            if not _all_known(names, target_context):
                raise Unfit
        found = CompileResult._rebuild(target_context, *whole)
        if not found.library.get_pointer_to_function(found.fndesc.llvm_cpython_wrapper_name):
            raise Unfit  # no entry for Python
        return found
    except MemoryError:
        raise
    except Exception as e:  # valid, but of a modified numba of the same version
        raise Unfit from e


def compiled(function: Callable[..., Any]) -> Any:
    """Return a kernel that is compiled at its first call and stored in the cache folder."""
    made: Any = Kernel(function)
    made._cache = KernelCache(function, cache_folder)
    return made
