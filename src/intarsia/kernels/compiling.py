"""How a kernel is compiled: once for each use, and machine code for those alone that Python calls.

numba makes machine code of every function that it meets, with entries for Python and for C, and does it once more
within each caller. What a kernel calls is kept here lowered and simplified; machine code is made of it where it is
linked into the kernel that Python calls, and it gets an entry for Python only if it is called from there.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite.binding import Linkage, create_pass_builder, create_pipeline_tuning_options
from numba.core import environment
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.types import unliteral as _unliteral

from .announcing import compilation_begins

unliteral: Any = _unliteral
_environment_of: Any = environment.lookup_environment

OPTIONS = {"nopython": True, "nogil": True, "boundscheck": None, "no_cfunc_wrapper": True}


class _NoEnvironments:
    """Stands for the code generator of a library of which no machine code is wanted (yet)."""

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: what is linked elsewhere has its environments set there."""


class Library(JITCodeLibrary):
    """Lowered functions that become machine code when an address of them is asked for, not when they are linked."""

    _codegen: Any

    @property
    def codegen(self) -> Any:
        """The code generator, once there is machine code."""
        return self._codegen if self._finalized else _NoEnvironments()

    def add_ir_module(self, ir_module: Any) -> None:
        """Add a lowered module, unless it lets C call a function: nobody does."""
        if ir_module.name != "cfunc_wrapper":
            plain: Any = super()
            plain.add_ir_module(ir_module)

    def add_linking_library(self, library: Any) -> None:
        """Say that functions of another library are called."""
        if not isinstance(library, Library):
            library._ensure_finalized()
        self._linking_libraries.append(library)

    def get_pointer_to_function(self, name: str) -> int:
        """Return the address of a function, 0 where there is none; machine code is made for it."""
        if not self._finalized and name not in {f.name for f in self._final_module.functions if not f.is_declaration}:
            return 0
        plain: Any = super()
        return int(plain.get_pointer_to_function(name))

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager()
                passes.run(function, builder)

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None and not self._finalized:
            module = self._final_module.clone()
            for library in dict.fromkeys(self._linking_libraries):
                self._reload_init.update(library._reload_init)
                module.link_in(library._get_module_for_linking(), preserve=True)
            # without this what is linked in is inlined less well: corrections took a sixth longer
            options = create_pipeline_tuning_options(speed_level=2)
            options.loop_vectorization = options.slp_vectorization = False
            options.loop_unrolling = False  # what is unrolled here fills no vector registers later: half as fast
            builder = create_pass_builder(self._codegen._tm, options)
            builder.getModulePassManager().run(module, builder)
            for function in module.functions:
                if not function.is_declaration and function.linkage == Linkage.external:
                    function.linkage = "linkonce_odr"
            self._shared_module = module
        plain: Any = super()
        return self._shared_module or plain._get_module_for_linking()

    def finalize(self) -> None:
        """Make machine code of all that is in here and all that it calls."""
        plain: Any = super()
        plain.finalize()
        self._shared_module = None  # from now on the one that holds the entry for Python, too
        for variable in self._final_module.global_variables:
            if (found := _environment_of(variable.name)) is not None:
                self._codegen.set_env(variable.name, found)


_depth = 0  # how many kernels are being compiled, each for the one before; behind numba's lock


@contextmanager
def _compiling() -> Iterator[None]:
    """Compile for a kernel: with the lean library for all that it calls, and without collections of garbage."""
    global _depth
    with global_compiler_lock:
        codegen = cpu_target.target_context.codegen()
        collects = gc.isenabled()
        if not _depth:
            gc.disable()
            codegen._library_class = Library
        _depth += 1
        try:
            yield
        finally:
            _depth -= 1
            if not _depth:
                del codegen._library_class
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
        types = tuple(getattr(sig, "args", sig))
        with _compiling():
            entry = super().compile(sig)
            called = self._called.pop(types, None) if _depth == 1 else None
            return entry if called is None else self._opened(sig, called)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Say what a call from another kernel returns; a written number is one of its type, not a type of its own."""
        return super().get_call_template([unliteral(a) for a in args], {n: unliteral(a) for n, a in kws.items()})

    def add_overload(self, cres: Any) -> None:
        """Have what was compiled called."""
        if cres.library.get_pointer_to_function(cres.fndesc.llvm_cpython_wrapper_name):
            super().add_overload(cres)
        else:
            self.overloads[tuple(cres.signature.args)] = self._called[tuple(cres.signature.args)] = cres

    def _compilation_chain_init_hook(self) -> None:
        """Load no extensions of numba: kernels need none, and finding them takes time."""

    def _flags(self, flags: Any) -> Any:
        compilation_begins()
        flags.no_cpython_wrapper = _depth > 1
        return flags

    def _opened(self, sig: Any, cres: Any) -> Any:
        """Have Python call what was compiled for other kernels; return its entry."""
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
