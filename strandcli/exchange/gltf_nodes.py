"""Which meshes the nodes of a glTF scene place, and where."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from .gltf_file import Gltf


def placed_meshes(file: Gltf, meshes: int) -> Iterator[tuple[int, npt.NDArray[np.float64], str]]:
    """The meshes of the scene, the matrices (4, 4) that place them, and names of nodes or meshes; each once where there
    are no nodes."""
    names = [_name(one) or f"mesh{k}" for k, one in enumerate(file.objects(file.header, "meshes"))]
    nodes = file.objects(file.header, "nodes")
    if not nodes:
        yield from ((k, np.eye(4), names[k]) for k in range(meshes))
    parents = [0] * len(nodes)
    for k, node in enumerate(nodes):
        children = node.get("children", [])
        if not isinstance(children, list):
            raise file.fault(f"nodes[{k}]", "children are no list")
        for child in children:
            file.named("nodes", child, f"nodes[{k}]")
            parents[child] += 1
    roots: Any = [k for k, count in enumerate(parents) if not count]
    if max(parents, default=0) > 1 or _reached(nodes, roots) < len(nodes):
        raise file.fault("nodes", "one has several parents, or some go round in a ring")
    if file.objects(file.header, "scenes"):
        scene = file.named("scenes", file.header.get("scene", 0), "scene")
        roots = scene.get("nodes", [])
    if not isinstance(roots, list) or len(set(map(repr, roots))) < len(roots):
        raise file.fault("scenes", "nodes are no list of nodes, each once")
    waiting = [(root, np.eye(4)) for root in reversed(roots)]
    while waiting:
        k, above = waiting.pop()
        node = file.named("nodes", k, "scenes")
        matrix = above @ _matrix(file, node, f"nodes[{k}]")
        if "mesh" in node:
            file.named("meshes", node["mesh"], f"nodes[{k}]")
            yield node["mesh"], matrix, _name(node) or names[node["mesh"]]
        waiting += [(child, matrix) for child in reversed(node.get("children", []))]


def _name(one: dict[str, Any]) -> str:
    """The name of a node or a mesh, empty where it has none."""
    found = one.get("name")
    return found if isinstance(found, str) else ""


def _reached(nodes: list[dict[str, Any]], roots: list[int]) -> int:
    """How many nodes hang on some roots, of nodes with one parent each at most; rings hang on none."""
    waiting, found = list(roots), 0
    while waiting and found <= len(nodes):
        found += 1
        waiting.extend(nodes[waiting.pop()].get("children", []))
    return found


def _matrix(file: Gltf, node: dict[str, Any], where: str) -> npt.NDArray[np.float64]:
    """The matrix (4, 4) by which a node places what hangs on it: its own, or translation · rotation · scale."""
    found = np.eye(4)
    columns = file.reals(node, "matrix", 16, where)
    if columns is not None:
        return columns.reshape(4, 4).T
    turn, shift, scale = (file.reals(node, *one, where) for one in (("rotation", 4), ("translation", 3), ("scale", 3)))
    if turn is not None and (size := float(np.linalg.norm(turn))) > 0:
        x, y, z, w = turn / size
        found[:3, :3] = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
    if scale is not None:
        found[:3, :3] *= scale
    if shift is not None:
        found[:3, 3] = shift
    return found
