"""What a run hands on for every frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class Frame:
    """One finished frame."""

    number: int
    image: NDArray[np.uint8] | None
    """(height, width, 3) sRGB, or (height, width, 4) with straight alpha where `image.background` is none; None where
    nothing was drawn."""
    positions: NDArray[np.float32] | None
    """(strands, particles, 3) metres, where they were asked for."""
    report: dict[str, Any]
    """Seconds a stage, counts and errors, as in report.json."""
    aovs: dict[str, NDArray[Any]] = field(default_factory=dict)
    """Layers that ``image.aovs`` asks for, by name: (height, width) or (height, width, 3); see `draw.aovs`."""
