"""The decorator of the simulator's functions, which picks where their machine code comes from."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast

from pirate_sm.core.errors import UsageError
from pirate_sm.simulation.machine_code.built_library import find_library
from pirate_sm.simulation.machine_code.entry_points import BY_PLACE

JIT_VARIABLE = "PIRATE_SM_JIT"
"""Environment variable; if it is set, functions are compiled when called, built or not."""

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Return the function by its machine code, built or to be compiled on its first call.

    In a module whose machine code was built, a function of the table of entry points runs as
    machine code. All others there are called by those, inside the library. Called from Python they
    are Python.

    Raises:
        UsageError: It is not built, and numba is not installed.
    """
    found, entry = find_library(), BY_PLACE.get((function.__module__, function.__name__))
    if found.library is not None and not os.environ.get(JIT_VARIABLE):
        if entry is not None:
            built = found.library.function(entry)
            built.__doc__ = function.__doc__
            return cast(_F, built)
        if found.library.covers(function.__module__):
            return function
    try:
        from pirate_sm.simulation.machine_code.just_in_time import compiled_when_called
    except ModuleNotFoundError as error:
        if error.name not in ("numba", "llvmlite"):
            raise
        why = found.why_not or f"{JIT_VARIABLE} is set"
        raise UsageError(
            f"the simulator cannot run here: {why}; pip install 'pirate-sm[jit]' lets it compile "
            "itself when it is first used (or use the backend trace)"
        ) from None
    return compiled_when_called(function, long=entry is not None and entry.long)


def compiled_module(module: ModuleType) -> Mapping[str, Callable[..., Any]]:
    """Return the functions of a module by name, as machine code that calls each other's.

    So the core's own source is compiled for the simulator, without knowing of it. Each function
    comes after those that it calls.
    """
    names = dict(vars(module))
    for name, own in vars(module).items():
        if isinstance(own, FunctionType) and own.__module__ == module.__name__:
            names[name] = compiled(FunctionType(own.__code__, names, name))
    return names


def is_kept(function: Callable[..., Any]) -> bool:
    """Return whether a compiled function can run at once; if not, its first call takes seconds."""
    if not hasattr(function, "py_func"):
        return True
    from pirate_sm.simulation.machine_code import just_in_time

    return just_in_time.is_kept(function)
