"""A kernel from the cache as what Numba runs, without what only its compiler needs.

Beside its machine code, an entry has the kernel's intermediate code, which Numba reads to link the kernel with others
that are compiled. Reading that takes half of the time in which a kernel is loaded, and most runs compile nothing.
"""

from __future__ import annotations

import io
import pickle
import sys
from typing import Any

import llvmlite.binding
from numba.core import environment
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult


class LoadedLibrary(JITCodeLibrary):
    """A kernel's machine code; its intermediate code is read when Numba asks for it."""

    _unread: bytes | None = None
    _read: Any = None

    @property
    def _shared_module(self) -> Any:
        if self._unread is not None:
            module = llvmlite.binding.parse_bitcode(self._unread)
            self._unread, self._read = None, module
            self._codegen._engine._load_defined_symbols(module)
        return self._read

    @_shared_module.setter
    def _shared_module(self, module: Any) -> None:
        self._unread, self._read = None, module

    def get_pointer_to_function(self, name: str) -> int:
        """Where a function of the kernel is, 0 for none. Names that nobody has asked for are known when all is read."""
        if not self._codegen._engine.is_symbol_defined(name):
            _ = self._shared_module
        return int(super().get_pointer_to_function(name))

    def take(self, machine_code: bytes, unread: bytes) -> None:
        """Become the kernel of an entry."""
        self.enable_object_caching()
        self._set_compiled_object(machine_code)
        self._unread = unread
        self._finalize_final_module()


class _Parts(pickle.Unpickler):
    """Reads the parts of an entry without importing the modules of all functions that a kernel holds copies of."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == ("numba.core.environment", "_rebuild_env"):
            return _environment
        return super().find_class(module, name)


def _environment(module: str, constants: Any, name: str) -> Any:
    """What `numba.core.environment._rebuild_env` returns. Of a module that nobody has imported, one with its constants
    alone, for this kernel: globals are read by code in object mode, which kernels are not."""
    found = environment.lookup_environment(name)
    if found is None and module in sys.modules:
        return environment._rebuild_env(module, constants, name)
    if found is None:
        found = environment.Environment({"__name__": module})
        found.consts[:] = constants
        found.env_name = name
    return found


def unpacked(payload: bytes) -> Any:
    """The parts of an entry, as `rebuilt` takes them, from a payload that has been checked."""
    return _Parts(io.BytesIO(payload)).load()


def rebuilt(
    context: Any, library: Any, description: Any, environment: Any, signature: Any, object_mode: Any, lifted: Any,
    annotation: Any, inits: Any, environments: Any,
) -> CompileResult:  # fmt: skip
    """What `CompileResult._rebuild` makes of the same arguments: the parts of an entry."""
    name, kind, content = library
    if kind != "object":
        raise ValueError(f"it holds no machine code but {kind}")
    for init in inits or ():
        init()
    codegen = context.codegen()
    loaded = LoadedLibrary(codegen, name)
    loaded.take(*content)
    codegen._engine._defined_symbols |= {description.llvm_cpython_wrapper_name, description.llvm_func_name}
    known = {
        "target_context": context, "typing_context": context.typing_context, "library": loaded,
        "environment": environment, "entry_point": context.get_executable(loaded, description, environment),
        "fndesc": description, "type_annotation": annotation, "signature": signature, "objectmode": object_mode,
        "lifted": lifted, "reload_init": inits, "referenced_envs": environments,
    }  # fmt: skip
    for one in environments:
        codegen.set_env(one.env_name, one)
    return CompileResult(**dict.fromkeys(CompileResult._fields) | known)
