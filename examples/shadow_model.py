#!/usr/bin/env python3
"""A shadow model of one's own, a ball of mist in the light's way: python examples/shadow_model.py out/mist

A package names `MODEL` under the entry point ``strandcli.shadow_models``: see `strandcli.draw.shadows.shadow_model`."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import strandcli
from strandcli.common.registry import SHADOWS
from strandcli.draw.shadows.shadow_model import ShadowModel
from strandcli.draw.shadows.vertex_shadows import StrandsInLight, VertexShadows
from strandcli.scene.fields import Vector, number, vector


@dataclass(frozen=True, slots=True)
class Parameters:
    """e^-τ of the light is left, τ = density · length of its way through the ball: what `shadow.parameters` takes."""

    centre: Vector = vector((0.0, 1.0, 0.0), unit="m", doc="middle of the ball")
    radius: float = number(0.5, above=0, unit="m", doc="of the ball")
    density: float = number(4.0, low=0, unit="1/m", doc="optical depth a metre")


class MistShadows(VertexShadows):
    def __init__(self, light: Any) -> None:
        self.own, self.light = light.shadow.parameters, light

    def visibility(self, lines: Any, marks: Any, screen: Any, out: Any) -> None:
        points = lines.world[marks != 0].astype(np.float64)
        near = self.light.kind == "point"
        way = np.array(self.light.position) - points if near else -np.broadcast_to(self.light.direction, points.shape)
        far = np.linalg.norm(way, axis=1)
        way, away = way / far[:, None], points - self.own.centre
        along = (away * way).sum(1)
        half = np.sqrt(np.maximum(self.own.radius**2 - (away**2).sum(1) + along**2, 0.0))
        begin, end = np.maximum(-along - half, 0.0), np.clip(-along + half, 0.0, far if near else None)
        out[marks != 0] = np.exp(-self.own.density * np.maximum(end - begin, 0.0))


class Mist(ShadowModel):
    name, shades_vertices, Parameters = "mist", True, Parameters

    def vertex_shadows(self, light: Any, strands: StrandsInLight) -> MistShadows:
        return MistShadows(light)


MODEL = Mist()
if __name__ == "__main__":
    SHADOWS.register(MODEL)
    path = Path(sys.argv[1] if len(sys.argv) > 1 else "out/mist") / "frame_0001.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    (frame,) = strandcli.render(strandcli.load("headline", ["lights.0.shadow.model=mist"]), frames=[1])
    Image.fromarray(frame.image).save(path)
