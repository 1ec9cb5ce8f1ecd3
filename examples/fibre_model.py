#!/usr/bin/env python3
"""A fibre model of one's own, the highlight of Kajiya and Kay (1989): python examples/fibre_model.py out/kajiya_kay"""

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

import strandcli
from strandcli.common.registry import FIBRES
from strandcli.constants import W
from strandcli.draw.common.kernels.batch import ARRIVES, EX, EY, EZ, LX, LY, LZ, RADIANCE, TX, TY, TZ
from strandcli.draw.common.kernels.light_columns import POWER_R
from strandcli.draw.fibre.kernels.highlights import shaded_by
from strandcli.jit import device
from strandcli.scene.fields import number

name = "kajiya_kay"


@dataclass(frozen=True, slots=True)
class Parameters:
    """S cos θ_l = strength · cos(θ_l + θ_v)^exponent: what `material.parameters` takes."""

    exponent: float = number(60.0, above=0, doc="how narrow the highlight is")
    strength: float = number(0.6, low=0, unit="1/sr", doc="how bright it is")


@device
def highlights(work, n, lights, i, tables):  # type: ignore[no-untyped-def]
    """Add the light of number i at the first n vertices of a batch: rows of W numbers."""
    for k in range(n):
        sin_l = work[TX + k] * work[LX + k] + work[TY + k] * work[LY + k] + work[TZ + k] * work[LZ + k]
        sin_v = work[TX + k] * work[EX + k] + work[TY + k] * work[EY + k] + work[TZ + k] * work[EZ + k]
        cosines = math.sqrt(max((1.0 - sin_l * sin_l) * (1.0 - sin_v * sin_v), 0.0))
        lobe = tables.numbers[1] * max(cosines - sin_l * sin_v, 0.0) ** tables.numbers[0]
        for c in range(3):
            work[RADIANCE + c * W + k] += work[ARRIVES + k] * lights[i, POWER_R + c] * lobe


@shaded_by(highlights)
class Arrays(NamedTuple):
    numbers: Any  # (2,) float32: exponent and strength


def tables(material: Any) -> Arrays:
    return Arrays(np.array([material.parameters.exponent, material.parameters.strength], np.float32))


if __name__ == "__main__":
    FIBRES.register(__import__("fibre_model"))  # by the name that kernels import it by
    path = Path(sys.argv[1] if len(sys.argv) > 1 else "out/kajiya_kay") / "frame_0001.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    (frame,) = strandcli.render(strandcli.load("headline", ["material.model=kajiya_kay"]), frames=[1])
    Image.fromarray(frame.image).save(path)
