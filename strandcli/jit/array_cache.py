"""Arrays that take long to compute, cached beside compiled kernels from one run to the next.

The tree over the triangles of a head, the grid of its distances, the tables of a material and what children follow take
half a second, longer than a small picture. A file's name is the hash of all that its arrays follow from: what they are
computed of, the text of the modules that compute them, and the versions and instructions that their bits depend on. One
that is damaged, or that other users may change, is made again; where none can be cached, arrays are made each time.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compiling import folder
from ..output.state_file import FREE, state_of, state_pieces

__all__ = ["FREE", "Arrays", "cached_arrays", "find", "keep", "key_of"]

SUFFIX = ".arrays"
STATES = "first-frame"
"""Kind of the states in which frames 1 begin, which take seconds to come to: a pack has them too."""
FOR_PACKS: set[str] = set()
"""Names of the states that this process has computed."""
LARGEST = 128 << 20
"""Bytes of a file's arrays, so that a few files of this size do not drive out the rest."""
SETTINGS = ("NPY_DISABLE_CPU_FEATURES", "NPY_ENABLE_CPU_FEATURES", "OPENBLAS_CORETYPE")
"""Variables that NumPy's bits may follow from."""

Arrays = Mapping[str, NDArray[Any]]


def cached_arrays(
    kind: str, code: Sequence[str], of: Iterable[Any], like: Arrays, make: Callable[[], Iterable[NDArray[Any]]]
) -> list[NDArray[Any]]:
    """The arrays that ``make`` computes, or a file's where there is one.

    ``code``: names of the modules that compute them; ``of``: arrays, and values that JSON has, that they are computed
    of; ``like``: arrays of their names, types and shapes, in their order. Those whose names begin with `FREE`
    have any length, and lose their shape.
    """

    def made() -> dict[str, NDArray[Any]]:
        found = zip(like, make(), strict=True)
        return {name: one.reshape(-1) if name.startswith(FREE) else one for name, one in found}

    if folder.cache.keeps_nothing:
        return list(made().values())
    key = key_of(kind, code, of)
    found = find(kind, key, like)
    if found is None:
        found = made()
        keep(kind, key, found)
    return list(found.values())


def find(kind: str, key: str, like: Arrays) -> Arrays | None:
    """The arrays that are cached under a key (see `key_of`), if there are such, of the types and shapes of ``like``."""
    if folder.cache.keeps_nothing or not folder.cache.arrays:
        return None
    return folder.cache.load(_name(kind, key), lambda file: state_of(file, key, like))


def keep(kind: str, key: str, arrays: Arrays) -> None:
    """Keep arrays under a key, where a file can be written and they are not too large."""
    if folder.cache.trouble is not None or sum(one.nbytes for one in arrays.values()) > LARGEST:
        return
    if folder.cache.write(folder.cache.path / _name(kind, key), state_pieces(key, arrays)) and kind == STATES:
        FOR_PACKS.add(_name(kind, key))


def _name(kind: str, key: str) -> str:
    return f"{kind}-{key[:24]}{SUFFIX}"


def key_of(kind: str, code: Sequence[str], of: Iterable[Any]) -> str:
    """64 hexadecimal digits: the hash of all that the bits of what is cached follow from."""
    from . import sources

    whole = hashlib.sha256(repr([kind, [sources.digest(one) for one in code], _machine()]).encode())
    for one in of:
        if isinstance(one, np.ndarray):
            whole.update(f"{one.dtype.str} {one.shape} ".encode())
            flat: Any = np.ascontiguousarray(one).reshape(-1)
            whole.update(memoryview(flat).cast("B"))
        else:
            whole.update(json.dumps(one, sort_keys=True).encode() + b"\0")
    return whole.hexdigest()


@functools.cache
def _machine() -> list[Any]:
    """Versions, and the instructions that NumPy's loops take. Kernels make the same bits on all processors of
    `strandcli.compiling.processor`."""
    import llvmlite.binding as llvm
    import numba

    try:
        from numpy.lib.introspect import opt_func_info

        found = opt_func_info("^(sin|exp|add|arcsin)$", "float")
        loops = str(sorted({one["current"] for kinds in found.values() for one in kinds.values()}))
    except ImportError:  # before NumPy 2.2
        loops = llvm.get_host_cpu_name()
    return [
        platform.machine(), loops, platform.libc_ver(), numba.__version__, llvm.llvm_version_info, np.__version__,
        [os.environ.get(name) for name in SETTINGS],
    ]  # fmt: skip
