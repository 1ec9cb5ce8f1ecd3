"""Bytes on disk that a run needs, before it begins."""

from __future__ import annotations

from collections.abc import Sequence

BYTES_PER_PIXEL = 1.5
"""Of a frame full of strands, measured as 0.4 to 1.6 (`png`)."""
_CHANNELS = {"tangent": 3, "linear": 4}


def frame_bytes(pixels: int, layers: Sequence[str] = (), exr: bool = False) -> int:
    """About so many bytes a frame at most: its picture, its layers, and their EXR file."""
    channels = sum(_CHANNELS.get(name, 1) for name in layers)
    return round((BYTES_PER_PIXEL + (10 if exr else 6) * channels) * pixels)
