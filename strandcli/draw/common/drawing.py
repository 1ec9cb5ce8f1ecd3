"""A picture with what it took."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class Drawing:
    """One picture with what it took; its clock runs from when it is made."""

    image: NDArray[np.uint8]
    """(height, width, 3) sRGB."""
    seconds: dict[str, float] = field(default_factory=dict)
    """By stage."""
    counts: dict[str, int] = field(default_factory=dict)
    curve_px_max: float | None = None
    aovs: dict[str, NDArray[Any]] = field(default_factory=dict)
    """Layers that the scene asks for, by name (see `strandcli.draw.film.aovs`)."""
    clock: float = field(default_factory=time.perf_counter)

    def lap(self, stage: str) -> None:
        """What has passed since the last lap was this stage."""
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self.clock
        self.clock = now
