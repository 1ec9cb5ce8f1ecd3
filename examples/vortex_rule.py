#!/usr/bin/env python3
"""A rule of one's own: strands are dragged round an axis, as by a whirlwind.

    python examples/vortex_rule.py out/vortex

A rule is any module or object with the four names below. Here the module registers itself; a package would name it
under the entry point ``strandcli.rules`` instead, and every preset could then list ``vortex``.
"""

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from strandcli.scene.fields import number
from strandcli.simulate.rules import Moment, Pass, register

name = "vortex"
order = 22.0  # after the wind, where a preset gives its rules as a mapping


@dataclass(frozen=True, slots=True)
class Parameters:
    """A pull round the y axis that falls off with the distance from it."""

    strength: float = number(5.0, unit="m/s²", doc="pull at one metre from the axis; negative turns the other way")
    core: float = number(0.3, above=0, unit="m", doc="inside of this distance the pull fades toward the axis")


def apply(a: Any, b: Any, c: Any, length: Any, p: Any) -> Any:
    """p[0]: strength Δt²; p[1]: core². The new place of a particle at a; b and c are those before it on its strand.
    Compiled by strandcli: arithmetic only, no branches."""
    pull = p[0] / (a[0] * a[0] + a[2] * a[2] + p[1])
    return a[0] + pull * a[2], a[1], a[2] - pull * a[0]


def passes(parameters: Parameters, scene: Any) -> list[Pass]:
    """One pass over every particle but the root."""

    def prepare(moment: Moment) -> Any:
        return np.array([parameters.strength * moment.step**2, parameters.core**2], np.float32)

    return [Pass(apply, prepare, stage="lane", numbers=2)]


def main(folder: Path) -> None:
    """Draw a head of hair in a whirlwind."""
    import vortex_rule  # the module by its importable name, which the compiled step imports it by
    from PIL import Image

    import strandcli

    register(vortex_rule)
    rules = ["gravity", {"vortex": {"strength": 60.0}}, {"stiffness": {"strength": 20.0}}, "collision", "elasticity"]
    scene = strandcli.load("headline", settings={"rules": rules, "time.preroll": 2.0})
    folder.mkdir(parents=True, exist_ok=True)
    for frame in strandcli.render(scene, frames=[1, 12]):
        path = folder / f"vortex_{frame.number:02d}.png"
        Image.fromarray(frame.image).save(path)
        stretch = frame.report["error"]["stretch_max"]
        print(f"{path}: greatest stretch {stretch:.1e}, turned {math.degrees(turn(frame.positions)):.0f} degrees")


def turn(positions: Any) -> float:
    """Mean angle about y between roots and tips, radians."""
    root, tip = positions[:, 0].astype(float), positions[:, -1].astype(float)
    cross = root[:, 2] * tip[:, 0] - root[:, 0] * tip[:, 2]
    dot = root[:, 0] * tip[:, 0] + root[:, 2] * tip[:, 2]
    return float(np.mean(np.arctan2(cross, dot)))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/vortex"))
