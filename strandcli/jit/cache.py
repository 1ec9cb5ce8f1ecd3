"""Compiled kernels on disk, a file for each kernel and signature, checked by its content's hash before it is run.

Numba's own cache is set for a whole process and looks at one source file a function; this one belongs to strandcli's
dispatchers alone, and an entry's name follows everything that its machine code depends on: the text of all modules that
the kernel is made of, the signature, the processor, the versions of Python, Numba and LLVM.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core import config
from numba.core.caching import _Cache
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from ..compiling import folder
from ..compiling.claims import claims
from ..compiling.clock import clock
from ..compiling.interrupts import interrupts
from ..compiling.service import service
from . import sources
from .loaded import rebuilt, unpacked

MAGIC = b"strandcli kernel 1\n"
SUFFIX = ".kernel"


class KernelCache(_Cache):
    """The entries of one dispatcher."""

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        self._function = function
        self._options = options

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
        name, key = self._entry(sig, target_context.codegen())
        found = self._load(folder.cache.find(name), key, target_context)
        if found is not None:
            return found
        clock.missed(self._function.__name__)
        folder.cache.missed()
        with interrupts.allowed():
            if not service.compile(self._function, sig, name):
                claims.take(folder.cache.path, key)
        # in the meantime another process may have compiled it
        return self._load(folder.cache.find(name), key, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a kernel that was compiled, whole or not at all."""
        if data.library.has_dynamic_globals or any(not one.can_cache for one in data.lifted):
            return
        name, key = self._entry(sig, data.codegen)
        payload = dumps(data._reduce())
        folder.cache.write(folder.cache.path / name, MAGIC + hashlib.sha256(key + payload).digest() + payload)

    def _load(self, path: Path, key: bytes, target_context: Any) -> Any:
        """The kernel in a file; None where there is none that is whole."""
        try:
            with folder.opened(path) as file:
                data = file.read()
            return rebuilt(target_context, *unpacked(_checked(data, key)))
        except FileNotFoundError:
            return None
        except Exception as error:
            clock.tell(f"{path}: cached kernel cannot be loaded ({error}): compiling anew")
            folder.cache.discard(path)
            return None

    def _entry(self, sig: Any, codegen: Any) -> tuple[str, bytes]:
        """The name of a signature's entry, and the hash of all that it depends on."""
        function = self._function
        parts = (
            sources.digest(function.__module__), function.__module__, function.__qualname__,
            function.__code__.co_firstlineno, sorted(self._options.items()), str(sig),
            sources.digests_of_types(sig), codegen.magic_tuple(),
            numba.__version__, llvmlite.__version__, platform.python_version(),
            str(getattr(config, "OPT", "")), getattr(config, "BOUNDSCHECK", None),
        )  # fmt: skip
        key = hashlib.sha256(repr(parts).encode()).digest()
        name = f"{function.__module__.rpartition('.')[2]}.{function.__name__}-{key.hex()[:24]}{SUFFIX}"
        return name, key


def _checked(data: bytes, key: bytes) -> bytes:
    """The payload of an entry. Raises `ValueError` where it is not what was written."""
    size = len(MAGIC) + 32
    payload = data[size:]
    if data[: len(MAGIC)] != MAGIC or data[len(MAGIC) : size] != hashlib.sha256(key + payload).digest():
        raise ValueError("its content is not what was written")
    return payload
