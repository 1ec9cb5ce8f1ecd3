"""Trees of meshes and grids of their distances, kept beside compiled kernels from one run to the next.

They take a quarter of a second for a head, half of what a small picture of it takes. A file's name is the hash of all
that they follow from: vertices and triangles, the text of the modules that make them, and the versions and instructions
that their bits depend on. It is checked by its own hash, and its arrays by their sizes; nothing in it is unpickled. One
that is damaged, or that others may change, is made again.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import stat
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compiling import folder
from ..compiling.clock import clock
from ..meshes.bvh import Bvh, make_bvh
from ..meshes.distance_grid import DistanceGrid, make_distance_grid
from ..meshes.mesh import TriangleMesh
from ..output.state_file import FREE, DamagedError, ForeignError, read_state, state_bytes

SUFFIX = ".mesh"
MOST_BYTES = 256 << 20
"""Of all such files: beyond it those that no run has read for longest are removed."""
CODE = ("strandcli.meshes.bvh", "strandcli.meshes.distance_grid")

Arrays = Mapping[str, NDArray[Any]]


def tree_of(mesh: TriangleMesh) -> Bvh:
    """The tree over a mesh's triangles."""
    count = len(mesh.triangles)
    like = {
        FREE + "boxes": np.empty(0, np.float32), FREE + "child": np.empty(0, np.int32),
        FREE + "counts": np.empty(0, np.int32), "corners": np.empty((count, 3, 3)),
        "triangle": np.empty(count, np.int32), FREE + "moments": np.empty(0),
    }  # fmt: skip

    def make() -> Arrays:
        return dict(zip(like, make_bvh(mesh.vertices, mesh.triangles), strict=True))

    boxes, child, counts, corners, triangle, moments = _kept("tree", (mesh.vertices, mesh.triangles), like, make)
    return Bvh(boxes.reshape(-1, 6), child, counts, corners, triangle, moments.reshape(len(child), -1))


def distances_of(bvh: Bvh, closed: bool, resolution: int) -> DistanceGrid:
    """The grid of distances from a mesh, as `make_distance_grid`."""
    like = {
        FREE + "values": np.empty(0, np.float32), "size": np.empty(3, np.int64), "low": np.empty(3, np.float32),
        "spacing": np.empty(1, np.float32),
    }  # fmt: skip

    def make() -> Arrays:
        values, low, spacing = make_distance_grid(bvh, closed, resolution)
        return dict(zip(like, (values, np.array(values.shape), low, np.array([spacing])), strict=True))

    values, size, low, spacing = _kept("grid", (*bvh, np.array([closed, resolution])), like, make)
    return DistanceGrid(values.reshape(size), low, spacing[0])


def _kept(kind: str, of: Sequence[NDArray[Any]], like: Arrays, make: Callable[[], Arrays]) -> list[NDArray[Any]]:
    """The arrays that `make` finds, those `FREE` without their shape, from a file where there is one."""
    if folder.cache.trouble is not None:
        return [one.reshape(-1) if name.startswith(FREE) else one for name, one in make().items()]
    key = _key(kind, of)
    path = folder.cache.path / f"{kind}-{key[:24]}{SUFFIX}"
    found = _read(path, key, like)
    if found is None:
        found = {name: one.reshape(-1) if name.startswith(FREE) else one for name, one in make().items()}
        if folder.cache.write(path, state_bytes(key, found)):
            _remove_oldest(path.parent)
    return list(found.values())


def _read(path: Path, key: str, like: Arrays) -> Arrays | None:
    """The arrays of a file; None where there is none that is whole. Its time says at least to the day when it was last
    used."""
    try:
        status = path.lstat()
        if others := folder.writers(status):
            raise DamagedError(others)
        if not stat.S_ISREG(status.st_mode):
            raise DamagedError("it is no file")
        found = read_state(path, key, like)
    except FileNotFoundError:
        return None
    except (DamagedError, ForeignError, OSError) as error:
        clock.tell(f"{path}: is not used ({error or 'it is of another mesh'}): made anew")
        folder.cache.discard(path)
        return None
    if status.st_mtime < time.time() - folder.DAY:
        with contextlib.suppress(OSError):
            os.utime(path)
    return found


def _key(kind: str, of: Sequence[NDArray[Any]]) -> str:
    """64 hexadecimal digits: the hash of all that the bits of what is kept follow from."""
    import llvmlite.binding as llvm
    import numba

    from ..jit import sources

    parts = [
        kind, [sources.digest(one) for one in CODE], [(one.dtype.str, one.shape) for one in of], platform.machine(),
        llvm.get_host_cpu_name(), platform.libc_ver(), numba.__version__, llvm.llvm_version_info, np.__version__,
    ]  # fmt: skip
    whole = hashlib.sha256(repr(parts).encode())
    for one in of:
        whole.update(np.ascontiguousarray(one))
    return whole.hexdigest()


def _remove_oldest(where: Path) -> None:
    """Remove those that were not used for longest, so that the others are within `MOST_BYTES`."""
    size = 0
    with contextlib.suppress(OSError), os.scandir(where) as found:
        mine = [(one.stat(follow_symlinks=False), one.path) for one in found if one.name.endswith(SUFFIX)]
        for status, path in sorted(mine, key=lambda one: one[0].st_mtime, reverse=True):
            size += status.st_size
            if size > MOST_BYTES:
                with contextlib.suppress(OSError):
                    os.unlink(path)
