#!/usr/bin/env python3
"""A shape of solid of one's own: hair that hangs over a ring.

    python examples/solid_shape.py out/ring.png

A shape is any module or object with the five names below. Here the module registers itself; a package would name it
under the entry point ``strandcli.solids`` instead, and every preset could then have solids of ``kind: ring``. It is
drawn, casts shadows and keeps strands out by its signed distance alone.
"""

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from strandcli.scene.fields import choice, number
from strandcli.scene.model import SolidSettings

kind = "ring"


@dataclass(frozen=True, slots=True, repr=False)
class Settings(SolidSettings):
    """A torus about its own y axis."""

    kind: str = choice("ring", ("ring",))
    radius: float = number(0.5, above=0, unit="m", doc="of the circle in its middle")
    thickness: float = number(0.1, above=0, unit="m", doc="radius of the tube")


def numbers(settings: Settings) -> tuple[float, ...]:
    return settings.radius, settings.thickness


def reach(settings: Settings) -> float:
    return settings.radius + settings.thickness


def distance(x: Any, y: Any, z: Any, p: Any) -> Any:
    """Compiled by strandcli; p is what `numbers` gave."""
    off = math.sqrt(x * x + z * z) - p[0]
    return math.sqrt(off * off + y * y) - p[1]


def main(path: Path) -> None:
    import solid_shape  # the module by its importable name, by which the compiled kernels import it
    from PIL import Image

    import strandcli
    from strandcli.solids import register

    register(solid_shape)
    tilted = {"kind": "ring", "position": [0, -0.5, 0], "rotation": [20, 0, 10], "colour": "#b08040", "coat": 0.04}
    settings = {
        "solver": "rod", "time.preroll": 2.0, "image.size": [640, 480], "camera.position": [0, 1.2, 4.5],
        "camera.target": [0, -0.5, 0], "emitter.shape": {"kind": "disc", "radius": 0.7}, "emitter.strands": 6000,
        "emitter.length": 1.2, "emitter.rotation": [180, 0, 0], "rules": ["gravity", "collision"],
        "solids": [tilted, {"kind": "plane", "position": [0, -1.4, 0], "colour": [0.4, 0.4, 0.4]}],
    }  # fmt: skip
    scene = strandcli.load("minimal", settings=settings)
    (frame,) = strandcli.render(scene, frames=[1])
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(frame.image).save(path)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/ring.png"))
