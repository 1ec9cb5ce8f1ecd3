"""Compiled kernels on disk, a file for each kernel and signature, checked by its content's hash before it is run.

Numba's own cache is set for a whole process and looks at one source file a function; this one belongs to strandcli's
dispatchers alone, and an entry's name follows everything that its machine code depends on: the text of all modules that
the kernel is made of, the signature, the processor, the versions of Python, Numba and LLVM.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import platform
import tempfile
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core import config
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from . import sources

MAGIC = b"strandcli kernel 1\n"
SUFFIX = ".kernel"


class KernelCache(_Cache):
    """The entries of one dispatcher."""

    def __init__(self, function: Any, options: dict[str, Any], store: Any) -> None:
        """``store``: the folder and what happens there, `strandcli.runtime`."""
        self._function = function
        self._options = options
        self._store = store

    @property
    def cache_path(self) -> str:
        return str(self._store.cache_folder())

    def enable(self) -> None:
        """Always on."""

    def disable(self) -> None:
        """Always on."""

    def flush(self) -> None:
        """Entries are never stale."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The kernel for a signature; None where it has to be compiled."""
        target_context.refresh()
        path, key = self._entry(sig, target_context.codegen())
        try:
            data = path.read_bytes()
        except OSError:
            return None
        try:
            return CompileResult._rebuild(target_context, *pickle.loads(_checked(data, key)))
        except Exception as error:
            self._store.damaged(path, error)
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a kernel that was compiled, whole or not at all."""
        if data.library.has_dynamic_globals or any(not one.can_cache for one in data.lifted):
            return
        path, key = self._entry(sig, data.codegen)
        payload = dumps(data._reduce())
        content = MAGIC + hashlib.sha256(key + payload).digest() + payload
        temporary = None
        try:
            handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".part")
            with open(handle, "wb") as out:
                out.write(content)
            os.replace(temporary, path)
        except OSError as error:
            if temporary is not None:
                Path(temporary).unlink(missing_ok=True)
            self._store.unwritable(error)

    def _entry(self, sig: Any, codegen: Any) -> tuple[Path, bytes]:
        """Where a signature's entry is, and the hash of all that it depends on."""
        function = self._function
        parts = (
            sources.digest(function.__module__), function.__module__, function.__qualname__,
            function.__code__.co_firstlineno, sorted(self._options.items()), str(sig), codegen.magic_tuple(),
            numba.__version__, llvmlite.__version__, platform.python_version(), config.OPT, config.BOUNDSCHECK,
        )  # fmt: skip
        key = hashlib.sha256(repr(parts).encode()).digest()
        name = f"{function.__module__.rpartition('.')[2]}.{function.__name__}-{key.hex()[:24]}{SUFFIX}"
        return Path(self._store.cache_folder()) / name, key


def _checked(data: bytes, key: bytes) -> bytes:
    """The payload of an entry. Raises `ValueError` where it is not what was written."""
    size = len(MAGIC) + 32
    payload = data[size:]
    if data[: len(MAGIC)] != MAGIC or data[len(MAGIC) : size] != hashlib.sha256(key + payload).digest():
        raise ValueError("its content is not what was written")
    return payload
