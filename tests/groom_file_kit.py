"""Files of made-up strands that hang from a ball, and scenes that draw them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import exchange_kit
import strandcli
from strandcli.groom.blocks import unpack
from strandcli.run import pipeline
from strandcli.run.stages import RunOptions, SimulationStage
from strandcli.scene.model import Scene

Strand = npt.NDArray[np.float32]
SMALL = {"image.size": (64, 48), "lights.0.shadow.size": 64, "lights.1.shadow.size": 64, "ambient_occlusion": None}


def hanging(counts: Sequence[int], seed: int = 1) -> list[Strand]:
    """Strands of so many points each, with roots on a ball and waves below; each in a box of some two units."""
    rng = np.random.default_rng(seed)
    found = []
    for count in counts:
        root = rng.normal(size=3)
        root /= np.linalg.norm(root)
        root[1] = abs(root[1])
        t = np.sort(rng.random(count))[:, None]
        away = root * (1 + 0.3 * np.sin(3 * t)) - np.array([0.0, 1.5, 0.0]) * t**2
        found.append((away + 0.05 * np.sin(9 * t + rng.random(3))).astype(np.float32))
    return found


def write(path: Path, strands: Sequence[Strand]) -> Path:
    """Strands as a .data file."""
    path.write_bytes(exchange_kit.data(strands))
    return path


def scene(path: Path, **settings: Any) -> Scene:
    """A small scene of the preset ``groom``, whose strands are where the file has them; ``__`` for dots."""
    given = {key.replace("__", "."): value for key, value in settings.items()}
    plain = {"emitter.groom.size": None, "emitter.groom.place": "file", "emitter.groom.up": "y"}
    return strandcli.load("groom", settings={**SMALL, **plain, "emitter.groom.file": str(path), **given})


def shown(given: Scene, frames: Sequence[int]) -> list[list[npt.NDArray[np.float32]]]:
    """What is drawn of each strand, in the order of the file, at frames, (points, 3)."""
    stage = SimulationStage(given, frames, None, RunOptions())
    found = []
    for number in frames:
        moved = stage.begin(number)
        groom = moved.groom or stage.groom
        found.append(list(groom.emitted(unpack(moved.positions, groom.strands)[:, 1:]).copy()))
    return found


def drawn(given: Scene, frame: int = 1) -> list[npt.NDArray[np.float32]]:
    """The same at one frame."""
    return shown(given, [frame])[0]


def image(given: Scene, frame: int = 1, **options: Any) -> npt.NDArray[np.uint8]:
    (found,) = pipeline.render(given, [frame], **options)
    assert found.image is not None
    return found.image
