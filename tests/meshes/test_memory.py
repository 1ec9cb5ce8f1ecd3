"""Memory that reading a mesh and telling what is in it takes: at most three times the file and 100 MB, beside what a
start of Python and of the compiled functions takes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mesh_kit as kit
from strandcli.meshes.mesh import TriangleMesh

RINGS = 512
"""Of the mesh, which has 522,000 triangles."""
TIMES, BESIDE = 3, 100e6
"""The bound: so many times the file, and so many bytes. Of these files of 9 to 26 MB, 46 to 93 MB were measured; the
rest is for other allocators and versions of NumPy."""
READ = """
import re, sys
from pathlib import Path
from strandcli.meshes.facts import facts_of_file

def peak():  # not getrusage's, which begins with that of the process that started this one
    return 1024 * int(re.search(r"VmHWM:\\s*(\\d+) kB", Path("/proc/self/status").read_text())[1])

facts_of_file(Path(sys.argv[1]))
before = peak()
facts_of_file(Path(sys.argv[2]))
print(peak() - before)
"""


def files(kind: str) -> tuple[str, bytes, bytes]:
    """The end of a name, and a small and a large file of a format."""
    small, (vertices, triangles) = kit.mesh("ball"), kit.head(RINGS)
    large = TriangleMesh(vertices.round(6), triangles.astype(np.int32), vertices)
    if kind == "stl":
        return ".stl", *(kit.stl(one) for one in (small, large))
    if kind == "obj":
        return ".obj", kit.obj(small), kit.obj(large)
    if kind == "glb":
        return ".glb", kit.glb(*kit.gltf_tree(small)), kit.glb(*kit.gltf_tree(large))
    more = {name: values.astype(np.float32) for name, values in zip(("nx", "ny", "nz"), vertices.T, strict=True)}
    few = {name: values[: len(small.vertices)] for name, values in more.items()}
    return ".ply", kit.ply(small, more=few), kit.ply(large, more=more)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="asks the system as Linux does")
@pytest.mark.parametrize("kind", ["stl", "glb", "obj", "normals"])
def test_a_mesh_is_read_and_told_of_in_little_memory(kind: str, tmp_path: Path) -> None:
    suffix, small, large = files(kind)
    paths = [tmp_path / f"{name}{suffix}" for name in ("small", "large")]
    for path, content in zip(paths, (small, large), strict=True):
        path.write_bytes(content)
    done = subprocess.run([sys.executable, "-c", READ, *map(str, paths)], capture_output=True, text=True, check=True)
    assert int(done.stdout) < TIMES * len(large) + BESIDE
