"""A shape of solid of one's own, hair that hangs over a ring: python examples/solid_shape.py ring.png

A shape is any module or object with the five names below. Here the module registers itself; a package would name it
under the entry point ``strandcli.solids`` instead, and every preset could then have solids of ``kind: ring``. It is
drawn, casts shadows and keeps strands out by its signed distance alone; a `meet` and a `normal` would be quicker.
"""

import math
import sys
from dataclasses import dataclass
from typing import Any

from PIL import Image

import strandcli
from strandcli.scene.fields import choice, number
from strandcli.scene.model import SolidSettings
from strandcli.solids import register

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


if __name__ == "__main__":
    import solid_shape  # by the name by which compiled kernels import it

    register(solid_shape)
    own = {"kind": "ring", "thickness": 0.15, "position": [0, -0.5, 0], "rotation": [25, 0, 10], "colour": "#c08030"}
    settings = {
        "solver": "rod", "rules": ["gravity", "collision"], "image.size": [640, 480], "camera.position": [0, 1.4, 4.2],
        "camera.target": [0, -0.6, 0], "emitter.shape": {"kind": "disc", "radius": 0.75}, "emitter.strands": 250,
        "emitter.rotation": [180, 0, 0], "material.width": 0.008,
        "solids": [own, {"kind": "plane", "position": [0, -1.3, 0], "colour": [0.4, 0.4, 0.4]}],
    }  # fmt: skip
    (frame,) = strandcli.render(strandcli.load("minimal", settings=settings), frames=[1])
    Image.fromarray(frame.image).save(sys.argv[1] if len(sys.argv) > 1 else "ring.png")
