"""The memory that pictures of a file's strands are planned to take, which follows from how these stand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import strandcli
from plan_figures import measured
from strand_kit import frames_of
from strandcli.draw.shadows.shadow import ShadowMaps
from strandcli.plan import make_plan
from strandcli.plan.memory import _map_bytes

KINDS = ("hanging", "brush", "tangle")


def groom(path: Path, kind: str, strands: int, points: int = 24) -> str:
    """A file of strands on half a ball that hang, that stand upright on a square, or that go anywhere at random."""
    rng, along = np.random.default_rng(7), np.linspace(0, 1, points, dtype=np.float32)[None, :, None]
    if kind == "brush":
        roots = rng.uniform(-0.1, 0.1, (strands, 1, 3)) * (1, 0, 1)
        lines = roots + 0.06 * along * (np.array([0, 1, 0]) + rng.normal(0, 0.05, (strands, 1, 3)))
    elif kind == "hanging":
        ways = rng.normal(size=(strands, 1, 3))
        ways *= np.where(ways[:, :, 1:2] < 0, (1, -1, 1), 1) / np.linalg.norm(ways, axis=2, keepdims=True)
        lines = (0.1 + 0.05 * along) * ways - 0.25 * along**2 * np.array([0, 1, 0])
    else:
        lines = np.cumsum(rng.normal(0, 0.01, (strands, points, 3)), axis=1)
    np.savez(path, positions=lines.astype(np.float32))
    return str(path)


@pytest.mark.parametrize("strands", [300, 3000])
@pytest.mark.parametrize("kind", KINDS)
def test_opacity_maps_of_a_file_are_planned(
    kind: str, strands: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As many bytes as their arrays have, within a third, from sparse grooms to dense ones."""
    path, taken = groom(tmp_path / "a.npz", kind, strands), []
    scene = strandcli.load("groom", settings={"emitter.groom.file": path, "image.size": [48, 36]})
    build = ShadowMaps.build

    def noted(maps: ShadowMaps, *arguments: Any) -> None:
        build(maps, *arguments)
        taken.append(4 * sum(maps._lengths) + sum(one.nbytes for one in maps.extents))

    monkeypatch.setattr(ShadowMaps, "build", noted)
    frames_of(scene, 1)
    planned = sum(_map_bytes(make_plan(scene, [1]), scene, light) for light in scene.lights)
    assert len(taken) == 1
    assert taken[0] / 1.34 < planned < taken[0] * 1.34


@pytest.mark.long
def test_memory_is_what_a_run_takes(tmp_path: Path) -> None:
    """Of dense strands that need most of their points; smooth ones, of which a picture leaves most out, take less."""
    path = groom(tmp_path / "a.npz", "tangle", 3000, 68)
    found = measured((path, "--size", "320x240", "-f", "1"), tmp_path, timed=False)
    assert found.within(), f"{found.planned / 1e6:.0f} MB planned, {found.peak / 1e6:.0f} MB measured"
