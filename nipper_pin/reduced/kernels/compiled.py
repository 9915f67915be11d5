"""Compilation with numba, and machine code that is kept on disk."""

from __future__ import annotations

import gc
import hashlib
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering

_Function = TypeVar("_Function", bound=Callable[..., object])
# Modules of tolerances whose constants are compiled into the functions of this folder.
_CONSTANTS = "hybrid", "mechanics", "reduced"


def compiled(function: _Function) -> _Function:
    """Compile a function to machine code at its first call, kept on disk where a folder allows it.

    It is called with arguments of the same types by all processes: what two of them keep of one
    function for different types at the same time may be taken for one another.
    """
    wrapped: Any = allocating(function)
    if numba.config.DISABLE_JIT:
        return function
    wrapped._compile_for_args = _collecting_nothing(wrapped._compile_for_args)
    kept = _kept(function)
    if kept is not None:
        wrapped._cache = kept
    return cast("_Function", wrapped)


def _collecting_nothing(function: _Function) -> _Function:
    """The same without collections of garbage meanwhile: a compilation makes little of it.

    They would take a sixth of its time.
    """

    @wraps(function)
    def call(*arguments: object, **named: object) -> object:
        enabled = gc.isenabled()
        gc.disable()
        try:
            return function(*arguments, **named)
        finally:
            if enabled:
                gc.enable()

    return cast("_Function", call)


def allocating(function: _Function) -> _Function:
    """Compile a function that makes arrays for compiled ones, and is kept with them.

    IEEE arithmetic in the order of the source: no fast-math, so a case gives the same bits alone
    and in a batch.
    """
    return cast("_Function", numba.njit(error_model="numpy", no_cfunc_wrapper=True)(function))


def part(function: _Function, *, inlined: bool = False) -> _Function:
    """Compile a function that only compiled ones call; called from Python it does nothing.

    It is typed, and becomes machine code in those that call it: machine code of its own, which
    nobody runs, would take half of the time of a first use. It counts no references, which would
    take half of the time of a turn: it makes no arrays, and returns views to other parts alone.
    """
    wrapped = numba.njit(
        error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, pipeline_class=_Typed,
        _nrt=False, forceinline=inlined,
    )(function)  # fmt: skip
    return cast("_Function", wrapped)


def inlined(function: _Function) -> _Function:
    """A part that stands where it is called: of each flight, a tenth of the time is spared so."""
    return part(function, inlined=True)


class _PartLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Code of a part, linked and optimised by what Python calls."""

    def finalize(self) -> None:
        """Leave it as it is."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(NativeLowering):  # type: ignore[misc]
    """Lowering of a part without machine code."""

    _name = "part_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower a part, and tell its callers of it."""
        state.library = _PartLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        # In the place of a function for Python, by which callers know this one.
        door: Any = [].append
        libraries = [state.library, *state.library._linking_libraries]
        state.targetctx.insert_user_function(door, state.cr.fndesc, libraries)
        state.reload_init.extend(state.library._reload_init)
        state["cr"] = state.cr._replace(cfunc=door)
        return True


class _Typed(CompilerBase):  # type: ignore[misc]
    """The steps of a compilation up to what is linked."""

    def define_pipelines(self) -> list[Any]:
        """Those of numba, but for the last but one."""
        steps = DefaultPassBuilder.define_nopython_pipeline(self.state)
        steps.passes = [
            (_PartLowering if step is NativeLowering else step, why) for step, why in steps.passes
        ]
        steps._finalized = False
        steps.finalize()
        return [steps]


def _kept(function: Callable[..., object]) -> _KeptCode | None:
    """The files of a function's machine code; None where no folder can be written."""
    try:
        return _KeptCode(function)
    except (RuntimeError, OSError):
        _tell_that_nothing_is_kept()
        return None


@cache
def _tell_that_nothing_is_kept() -> None:
    warnings.warn(
        "no folder can be written for the machine code of the reduced engine, so each process "
        "compiles it anew, which takes ten to twenty seconds; set NUMBA_CACHE_DIR to your own "
        "folder",
        RuntimeWarning,
        stacklevel=2,
    )


@cache
def _tell_that_it_takes_time() -> None:
    sys.stderr.write("compiling the reduced engine, once on this machine: ten to twenty seconds\n")


@cache
def _sources() -> str:
    """Digest of what is compiled: functions are compiled into others, and constants into them."""
    here = Path(__file__).parent
    constants = (here.parents[1] / "tolerances" / f"{name}.py" for name in _CONSTANTS)
    files = sorted([*here.glob("*.py"), *constants])
    return hashlib.sha256(b"\0".join(file.read_bytes() for file in files)).hexdigest()


class _KeptCode(FunctionCache):  # type: ignore[misc]
    """The cache of a function for the sources of all functions.

    These are in the names of its files: a kill may leave an index beside machine code of before.
    """

    def __init__(self, function: Callable[..., object]) -> None:
        super().__init__(function)
        sources = _sources()
        name = f"{self._impl.filename_base}-{sources[:16]}"
        self._cache_file = IndexDataCacheFile(self._cache_path, name, sources)

    def load_overload(self, sig: object, target_context: object) -> object:
        """Machine code of a signature; None, which is told, if it is to be compiled."""
        found = None
        try:
            found = super().load_overload(sig, target_context)
        except Exception:
            # A file that was cut off raises anything.
            with suppress(OSError):
                self.flush()
        if found is None:
            _tell_that_it_takes_time()
        return found

    def save_overload(self, sig: object, data: object) -> None:
        """Keep machine code, if the disk takes it; else the next process compiles it again."""
        with suppress(OSError):
            super().save_overload(sig, data)
