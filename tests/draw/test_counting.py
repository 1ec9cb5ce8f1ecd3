"""What a counting renderer counts, against counts made otherwise, and its pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.draw import counting
from strandcli.draw.common.drawing import Drawing, ProcessorDrawing
from strandcli.draw.renderer import Renderer
from strandcli.run.frame import FrameRenderer
from strandcli.run.stages import RunOptions, SimulationStage
from strandcli.scene import Scene

HAIRY = """
emitter: {strands: 40, particles: 5, length: 0.5}
image: {size: [64, 48], resolver: %s, supersample: %d, aovs: [solid]}
material: {width: 0.01}
children: {count: 3}
solids:
- {kind: plane, position: [0, -0.5, 0]}
lights:
- {kind: directional, direction: [0, -1, 0.5], shadow: {model: %s, size: 64}}
- {kind: point, position: [1, 2, 1], shadow: {model: off}}
"""


def drawn(scene: Scene, kind: type[Renderer]) -> Any:
    """The first frame."""
    moved = SimulationStage(scene, [1], None, RunOptions())
    return FrameRenderer(moved, kind)(moved.begin(1))


def test_counts_of_a_z_buffer_are_those_of_its_lines_and_keys() -> None:
    scene = scene_of(HAIRY % ("zbuffer", 1, "minmax"))
    frame, plain = drawn(scene, counting.CountingRenderer), drawn(scene, Renderer)
    counts = frame.report["counts"]
    assert np.array_equal(frame.image, plain.image)
    assert counts["strand_samples"] == plain.report["counts"]["fragments"]
    assert counts["line_samples"] >= counts["strand_samples"] > 0
    assert counts["map_texels"] > 0


@pytest.mark.parametrize("kind", [Drawing, ProcessorDrawing])
def test_counting_is_charged_to_no_stage(kind: type[Drawing]) -> None:
    drawing = kind(np.zeros((1, 1, 3), np.uint8))
    assert 0 <= drawing.now() - drawing.clock < 60
    with counting.unclocked(drawing):
        while_inside = drawing.clock
    assert drawing.clock > while_inside
    drawing.lap("shade")
    assert 0 <= drawing.seconds["shade"] < 60
