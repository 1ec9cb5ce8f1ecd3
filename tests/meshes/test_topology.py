"""Edges of meshes, against going through all of them."""

from __future__ import annotations

from collections import Counter, defaultdict

import numpy as np
import pytest

import mesh_kit as kit
from strandcli.meshes.kernels.topology import ALONE, CROWDED, balanced
from strandcli.meshes.topology import across_edges, edges_in_order

VERTICES = 9


def some(name: str) -> np.ndarray:
    """Triangles (T, 3) int32: of a closed ball, of a bowl, a fan about one vertex, and any."""
    if name in ("ball", "bowl"):
        return kit.mesh(name).triangles
    if name == "fan":
        return np.array([(0, k, k + 1) for k in range(1, 500)], np.int32)
    generator = np.random.default_rng(int(name))
    found = generator.integers(VERTICES, size=(60, 3)).astype(np.int32)
    return found[[len({*one}) == 3 for one in found.tolist()]]


def half_edges(triangles: np.ndarray) -> list[tuple[int, int]]:
    return [(one[k], one[(k + 1) % 3]) for one in triangles.tolist() for k in range(3)]


@pytest.mark.parametrize("name", ["ball", "bowl", "fan", "0", "1", "2", "3"])
def test_triangles_meet_where_they_share_an_edge(name: str) -> None:
    triangles = some(name)
    order = edges_in_order(triangles, int(triangles.max()) + 1)
    halves = half_edges(triangles)
    assert order.tolist() == sorted(range(len(halves)), key=lambda h: (min(halves[h]), max(halves[h]), h))
    neighbours, opposed, crowded = across_edges(triangles, order)
    at: dict[tuple[int, int], list[int]] = defaultdict(list)
    for h, (a, b) in enumerate(halves):
        at[min(a, b), max(a, b)].append(h)
    assert crowded == sum(len(those) > 2 for those in at.values())
    for those in at.values():
        for h in those:
            other = [one for one in those if one != h] if len(those) == 2 else []
            assert neighbours.reshape(-1)[h] == (other[0] // 3 if other else ALONE if len(those) == 1 else CROWDED)
            assert opposed.reshape(-1)[h] == (bool(other) and halves[other[0]] == halves[h])


@pytest.mark.parametrize("name", ["ball", "bowl", "0"])
def test_a_closed_mesh_is_balanced_and_one_with_a_turned_triangle_is_not(name: str) -> None:
    triangles = some(name)
    order = edges_in_order(triangles, int(triangles.max()) + 1)
    for turned in np.random.default_rng(4).random((4, triangles.shape[0])) < np.array([[0], [0.01], [0.5], [1]]):
        wound = np.where(turned[:, None], triangles[:, ::-1], triangles)
        there = Counter(half_edges(wound))
        expected = all(there[b, a] == count for (a, b), count in there.items())
        assert balanced(triangles, order, turned) == expected
