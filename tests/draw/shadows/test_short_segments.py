"""Segments that single precision can hardly tell from points, and those at the borders of an opacity map."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.shadows.kernels.opacity import HEAD
from strandcli.draw.shadows.shadow import plan_maps
from strandcli.scene.model import DirectionalLight, PointLight, Shadow

BOX = np.array([[-1.0, -1, -1], [1, 1, 1]])
DEEP = Shadow(model="opacity", size=64, layers=13, texel=1e-6)
SUN = DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=DEEP)
LAMP = PointLight(position=(2.0, 4.0, 1.0), shadow=DEEP)


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
@pytest.mark.parametrize("step", [1e-7, 1e-6, 1e-4, 0.02])
def test_what_they_add_is_a_number_and_not_negative(light: DirectionalLight | PointLight, step: float) -> None:
    rng = np.random.default_rng(1)
    roots = rng.uniform(-1.6, 1.6, (4000, 1, 3))  # the map ends at 1
    world = (roots + step * rng.normal(size=(4000, 4, 3)).cumsum(1)).astype(np.float32)
    maps = plan_maps((light,), BOX, Scratch(), Thickness(0.01, 0.5))
    assert maps is not None
    maps.build(Polylines(np.arange(4001) * 4, world.reshape(-1, 3)), 2, Scratch())
    cells = int(maps.sizes[0] // 2) ** 2
    rows = maps.stacks[HEAD * cells :]
    assert np.isfinite(rows).all()
    assert rows.min() >= 0
    assert rows.max() < 200 * step + 1e-3
