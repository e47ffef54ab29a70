"""Compiles the entry points by numba to one object file; runs as a program of its own in the build.

    python -m pirate_sm.simulation.machine_code.object_file FILE

Each entry point gets a C function in front: `int f(int64 *arrays, numbers ..., void *result)`.
`arrays` holds the address and the shape of each array in order. The function returns 0 unless it
failed. Nothing of numba's runtime is needed, as no function gets memory of its own; `support.c`
takes the place of a C function of numba's.
"""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import Any

from llvmlite import ir
from llvmlite.binding import Linkage
from numba.core import types
from numba.core.compiler import Flags, compile_extra
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.core.types import containers
from numba.np.arrayobj import populate_array

from pirate_sm.simulation.machine_code.builder import SOURCES
from pirate_sm.simulation.machine_code.built_library import MANIFEST, digest
from pirate_sm.simulation.machine_code.entry_points import (
    ARRAYS,
    ENTRY_POINTS,
    Argument,
    EntryPoint,
)

_NUMBERS = {"float": types.float64, "int": types.int64, "bool": types.boolean, "None": types.none}


def write_object_file(into: Path) -> None:
    """Write the object file, for any processor of this machine's kind."""
    sources = digest(SOURCES)  # as they are before: a file that changes meanwhile must not fit
    context = cpu_target.target_context.with_aot_codegen("pirate_sm", cpu_name="")
    with global_compiler_lock:
        library = context.codegen().create_library("pirate_sm")
        compiled = [_compile(entry, context, library) for entry in ENTRY_POINTS]
        library.add_ir_module(_fronts(compiled, sources, context, library))
        library.finalize()
        _hide(library, {entry.symbol for entry in ENTRY_POINTS})
        into.write_bytes(library.emit_native_object())


def _compile(entry: EntryPoint, context: Any, library: Any) -> Any:
    """Compile an entry point and what it calls into the library, as numba does on a first call."""
    arguments = tuple(map(_type, entry.arguments))
    flags = Flags()
    flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    # No function gets memory of its own: numba would count who uses each array, with locks.
    flags.nrt = False
    flags.error_model = "numpy"
    function = getattr(importlib.import_module(entry.module), entry.name).py_func
    typing, result = cpu_target.typing_context, _NUMBERS[entry.result]
    return compile_extra(typing, context, function, arguments, result, flags, {}, library=library)


def _type(argument: Argument) -> Any:
    if argument.members:
        return containers.Tuple(tuple(map(_type, argument.members)))
    if argument.dimensions:
        return types.Array(getattr(types, ARRAYS[argument.kind].type), argument.dimensions, "C")
    return _NUMBERS[argument.kind]


def _fronts(compiled: Sequence[Any], sources: str, context: Any, library: Any) -> Any:
    """Return a module with a C function in front of each compiled one, and the list of sources."""
    module = library.create_ir_module("fronts")
    for entry, each in zip(ENTRY_POINTS, compiled, strict=True):
        _front(entry, each, context, module)
    text = json.dumps({"files": SOURCES, "digest": sources}).encode() + b"\0"
    constant = ir.Constant(ir.ArrayType(ir.IntType(8), len(text)), bytearray(text))
    manifest = ir.GlobalVariable(module, constant.type, MANIFEST)
    manifest.global_constant = True
    manifest.initializer = constant
    return module


def _front(entry: EntryPoint, compiled: Any, context: Any, module: Any) -> None:
    """Write the C function of an entry point."""
    word, real = ir.IntType(64), ir.DoubleType()
    numbers = [real if each.kind == "float" else word for each in entry.numbers]
    results = [] if entry.result == "None" else [word.as_pointer()]
    signature = ir.FunctionType(ir.IntType(32), [word.as_pointer(), *numbers, *results])
    front = ir.Function(module, signature, entry.symbol)
    builder = ir.IRBuilder(front.append_basic_block())
    places = (builder.gep(front.args[0], [ir.Constant(word, i)]) for i in count())
    words, given = map(builder.load, places), iter(front.args[1:])

    def value(argument: Argument, kind: Any) -> Any:
        if argument.members:
            members = list(map(value, argument.members, kind.types))
            return context.make_tuple(builder, kind, members)
        if argument.dimensions:
            return _array(words, kind, context, builder)
        if argument.kind == "bool":
            return builder.icmp_signed("!=", next(given), ir.Constant(word, 0))
        return next(given)

    status, result = context.call_conv.call_function(
        builder,
        context.declare_function(module, compiled.fndesc),
        compiled.signature.return_type,
        compiled.signature.args,
        list(map(value, entry.arguments, compiled.signature.args)),
    )
    if results:
        whole = builder.zext(result, word) if entry.result == "bool" else result
        builder.store(whole, builder.bitcast(front.args[-1], whole.type.as_pointer()))
    builder.ret(status.code)


def _array(words: Any, kind: Any, context: Any, builder: Any) -> Any:
    """Return an array as numba passes it, of the next words: its address and its shape."""
    element = context.get_data_type(kind.dtype)
    size = context.get_abi_sizeof(element)
    address = builder.inttoptr(next(words), element.as_pointer())
    shape = [next(words) for _ in range(kind.ndim)]
    strides = [ir.Constant(ir.IntType(64), size)]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    array = context.make_array(kind)(context, builder)
    populate_array(array, address, shape, strides, itemsize=size, meminfo=None)
    return array._getvalue()


def _hide(library: Any, exported: set[str]) -> None:
    """Let a library show only the functions that are called from outside."""
    own = {Linkage.private, Linkage.internal}
    for function in library.get_defined_functions():
        if function.name not in exported and function.linkage not in own:
            function.visibility = "hidden"


if __name__ == "__main__":
    write_object_file(Path(sys.argv[1]))
