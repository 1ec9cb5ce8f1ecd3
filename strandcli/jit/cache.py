"""Compiled kernels on disk, a file for each kernel and signature, checked by its content's hash before it is run.

An entry's name follows everything that its machine code depends on: the text of all modules that the kernel is made of,
the signature, the processor, the versions of Python, Numba and LLVM. A pack's kernels were compiled for its processor,
and are asked for under the names that they have for that one.
"""

from __future__ import annotations

import hashlib
import io
import pickle
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import MAGIC_NUMBER
from typing import Any, BinaryIO

import llvmlite
import llvmlite.binding
import numba
import numpy as np
from numba.core import config, environment
from numba.core.caching import _Cache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from ..compiling import folder
from ..compiling.clock import clock
from ..compiling.interrupts import interrupts
from ..compiling.processor import lacking
from ..compiling.service import claims, service
from ..compiling.stores import Store
from . import array_cache, sources

MAGIC = b"strandcli kernel 1\n"
SUFFIX = ".kernel"
WRITTEN = re.compile("_[0-9a-f]{16}$")
"""The end of the name of a module that strandcli writes for a scene."""
MADE_OF: dict[str, str] = {}
"""The module of each entry that this process has loaded or written, by the entry's name."""


class KernelCache(_Cache):
    """The entries of one dispatcher."""

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        self._function = function
        self._options = options
        self.name = f"{WRITTEN.sub('', function.__module__.rpartition('.')[2])}.{function.__name__}"

    @property
    def cache_path(self) -> str:
        return str(folder.cache.path)

    def enable(self) -> None:
        """Always on."""

    def disable(self) -> None:
        """Always on."""

    def flush(self) -> None:
        """Entries are never stale."""

    @contextmanager
    def claims(self) -> Iterator[None]:
        """A block after which no entry is claimed that was not before, however it ends."""
        before = claims.count()
        try:
            yield
        finally:
            claims.release(before)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The kernel for a signature; None where it has to be compiled, by this process, which has claimed it."""
        rtsys.initialize(target_context)  # which refresh() does, and imports all that only the compiler needs
        found = self._find(sig, target_context)
        if found is not None:
            return found
        clock.missed(self._function.__name__)
        self._explain()
        name, key = self._entry(sig, target_context.codegen())
        with interrupts.allowed():
            if not service.compile(self._function, sig, name):
                claims.take(folder.cache.path, key)
        # in the meantime another process may have compiled it
        return self._find(sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a kernel that was compiled, whole or not at all."""
        if data.library.has_dynamic_globals or any(not one.can_cache for one in data.lifted):
            return
        name, key = self._entry(sig, data.codegen)
        payload = dumps(data._reduce())
        MADE_OF[name] = self._function.__module__
        folder.cache.write(folder.cache.path / name, MAGIC + hashlib.sha256(key + payload).digest() + payload)

    def _find(self, sig: Any, target_context: Any) -> Any:
        """The kernel from the first place that has it whole; None where there is none."""
        codegen = target_context.codegen()
        for store in folder.cache.stores:
            if store.made is not None and (why := unfit(store.made, codegen)):
                folder.cache.refuse(store, why)
                continue
            name, key = self._entry(sig, codegen, store)

            def read(file: BinaryIO, key: bytes = key) -> CompileResult:
                return rebuilt(target_context, *unpacked(_checked(file.read(), key)))

            found = store.load(name, read)
            if found is not None:
                MADE_OF[name] = self._function.__module__
                return found
        return None

    def _explain(self) -> None:
        """Tell why the cache may not have had a kernel that is compiled now."""
        module = self._function.__module__
        for store in folder.cache.read_only:
            written = (store.made or {}).get("sources", {}).get(module)
            if written is not None and written != sources.digest(module):
                folder.cache.refuse(
                    store, f"kernels such as those of {module} are not run, for their sources have changed", whole=False
                )
        folder.cache.missed()

    def _entry(self, sig: Any, codegen: Any, store: Store | None = None) -> tuple[str, bytes]:
        """The name of a signature's entry in a store, and the hash of all that it depends on."""
        function = self._function
        made = made_with(codegen) if store is None or store.made is None else store.made
        parts = (
            sources.digest(function.__module__), function.__module__, function.__qualname__,
            function.__code__.co_firstlineno, sorted(self._options.items()), str(sig),
            sources.digests_of_types(sig), sorted(made["with"].items()), sorted(made["processor"].items()),
        )  # fmt: skip
        key = hashlib.sha256(repr(parts).encode()).digest()
        return f"{self.name}-{key.hex()[:24]}{SUFFIX}", key


def made_with(codegen: Any) -> dict[str, dict[str, str]]:
    """What machine code depends on beside its sources.

    Of Python the number of its bytecode and the name of its binary interface, which releases of one minor version
    share: kernels call Python as extension modules do, and what is pickled with them may hold bytecode.
    """
    triple, name, features = codegen.magic_tuple()
    settings = ("OPT", "BOUNDSCHECK", "USING_SVML")
    surroundings = {
        "Python": f"{int.from_bytes(MAGIC_NUMBER[:2], 'little')} {EXTENSION_SUFFIXES[0]}",
        "Numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "NumPy": np.__version__.partition(".")[0],
        "system": re.sub(r"(darwin|macosx)[\d.]+", r"\1", triple),
        "Numba's settings": " ".join(str(getattr(config, one, "")) for one in settings),
    }
    return {"with": surroundings, "processor": {"name": name, "features": features}}


def unfit(made: dict[str, Any], codegen: Any) -> str:
    """Why no kernel of a pack can be run here, in words; "" where they can."""
    for what, here in made_with(codegen)["with"].items():
        if made["with"].get(what) != here:
            return f"is not run, for its {what} is {made['with'].get(what)}, and here it is {here}"
    lacks = lacking(str(made["processor"].get("features")))
    name = made["processor"].get("name")
    return f"is not run, for it is for processors such as {name}, and this one has no {lacks[0]}" if lacks else ""


def pack_content() -> tuple[dict[str, Any], dict[str, bytes]]:
    """What a pack says of itself, and the entries of all kernels that this process has run, and of states in which
    presets begin that took long to come to."""
    from numba.core.registry import cpu_target

    made = made_with(cpu_target.target_context.codegen())
    whole = {**made, "sources": {module: sources.digest(module) for module in sorted(set(MADE_OF.values()))}}
    names = sorted({*MADE_OF, *array_cache.FOR_PACKS})
    found = {name: folder.cache.load(name, lambda file: file.read()) for name in names}
    return whole, {name: data for name, data in found.items() if data is not None}


def _checked(data: bytes, key: bytes) -> bytes:
    """The payload of an entry. Raises `ValueError` where it is not what was written."""
    size = len(MAGIC) + 32
    payload = data[size:]
    if data[: len(MAGIC)] != MAGIC or data[len(MAGIC) : size] != hashlib.sha256(key + payload).digest():
        raise ValueError("its content is not what was written")
    return payload


class LoadedLibrary(JITCodeLibrary):
    """A kernel's machine code; its intermediate code, with which Numba links it with kernels that are compiled, is read
    when Numba asks for it: that takes half of the time in which a kernel is loaded, and most runs compile nothing."""

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
        """Where a function of the kernel is, 0 for none. Names that were never asked for are known when all is read."""
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
    """What `numba.core.environment._rebuild_env` returns. Of a module that has not been imported, one with its
    constants alone, for this kernel: globals are read by code in object mode, which kernels are not."""
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
