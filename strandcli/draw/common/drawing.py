"""One picture, with its layers, and the run times and counts of drawing it."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class Drawing:
    """One picture, and what drawing it took. The clock starts when the object is made."""

    image: NDArray[np.uint8]
    """(height, width, channels) sRGB, as `Frame.image`."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Run time of each stage."""
    counts: dict[str, int] = field(default_factory=dict)
    """Numbers of strands, segments and fragments, and bytes of memory, by name, for the report."""
    curve_px_max: float | None = None
    """Greatest distance of a polyline from its curve, pixels; None if curves are not adaptive."""
    follow_stretch_max: float | None = None
    """Greatest share by which a strand's length had changed before it got it back; None: none follows guides."""
    aovs: dict[str, NDArray[Any]] = field(default_factory=dict)
    """AOVs of the scene, by name (see `strandcli.draw.film.aovs`)."""
    clock: float = field(default_factory=time.perf_counter)
    """Time of the last lap, seconds."""

    now = staticmethod(time.perf_counter)
    """Tells seconds."""

    def lap(self, stage: str) -> None:
        """Add the time since the last lap to a stage."""
        now = self.now()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self.clock
        self.clock = now


@dataclass
class ProcessorDrawing(Drawing):
    """A `Drawing` whose seconds are those of the processor, of all threads, whatever else the machine does."""

    clock: float = field(default_factory=time.process_time)
    now = staticmethod(time.process_time)
