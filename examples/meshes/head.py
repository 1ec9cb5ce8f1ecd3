"""The head of the presets: a calm adult face with closed eyes, ears, neck and shoulders, as `presets/meshes/head.ply`.

Metres, y up, facing +z, the origin in the middle of the skull. Proportions follow the usual canons: the eyes half-way
between crown and chin; hairline to brow, brow to nose and nose to chin alike; ears from brow to nose.

    python examples/meshes/head.py                            # writes presets/meshes/head.ply, in a minute
    python examples/meshes/head.py sketch.ply --coarser 2     # with a quarter of the triangles
"""

from __future__ import annotations

import numpy as np
from head_shape import LID, MOUTH, ears, head
from model import Model, Points, blob, command, from_stroke, graded, mixed, step
from sculpt import Sculpture

BROW = [(0.0125, 0.0010, 0.0032), (0.0220, 0.0050, 0.0036), (0.0340, 0.0082, 0.0030), (0.0450, 0.0070, 0.0022),
        (0.0530, 0.0015, 0.0012)]  # fmt: skip
"""Eyebrow, seen from ahead: (x, y, half its width)."""
HAIRLINE = [(0, 0.0600), (18, 0.0590), (32, 0.0560), (44, 0.0470), (52, 0.0330), (58, 0.0180), (64, 0.0040),
            (69, -0.0120), (74, -0.0290), (86, -0.0320), (91, -0.0050), (96, 0.0020), (108, 0.0020), (118, -0.0200),
            (126, -0.0520), (138, -0.0760), (152, -0.0900), (180, -0.0960)]  # fmt: skip
"""Height of the hairline over the angle from the face, in degrees: temples, sideburns, round the ear, nape."""


def axes(spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates of the grid: fine at the head, coarse at the shoulders."""
    return (
        graded(-0.26, 0.26, (-0.085, 0.085), spacing, 4 * spacing),
        graded(-0.47, 0.11, (-0.140, 0.098), spacing, 4 * spacing),
        graded(-0.16, 0.14, (-0.045, 0.120), spacing, 3 * spacing),
    )


def size(points: Points) -> np.ndarray:
    """Wanted length of edges: short at eyes, mouth, nose and ears."""
    there = np.column_stack([np.abs(points[:, 0]), points[:, 1:]])
    found = 0.0080 + 0.0080 * step(points[:, 1], -0.13, -0.24)
    for centre, reach, wanted in (
        ((0, -0.040, 0.070), (0.060, 0.075, 0.050), 0.0038),
        ((0.0315, -0.020, 0.070), (0.019, 0.010, 0.020), 0.00165),
        ((0.0330, 0.005, 0.070), (0.022, 0.006, 0.025), 0.0020),
        ((0, -0.088, 0.090), (0.027, 0.011, 0.020), 0.0016),
        ((0, -0.058, 0.100), (0.019, 0.013, 0.020), 0.0020),
        ((0.077, -0.030, -0.020), (0.020, 0.038, 0.024), 0.0024),
        ((0, -0.240, 0.010), (0.120, 0.015, 0.040), 0.0115),
    ):
        far = np.linalg.norm((there - centre) / reach, axis=1)
        found = np.minimum(found, wanted + 0.016 * step(far, 1, 2.4))
    return found


def pose(points: Points) -> Points:
    """Displacement that makes the face a little less even: mouth and nose aside, one brow and one ear higher."""
    x, y, z = points.T
    shift = np.zeros_like(points)
    front = step(z, 0.02, 0.09)
    shift[:, 0] = 0.0011 * front * np.exp(-(((y + 0.085) / 0.030) ** 2)) + 0.0006 * front * np.exp(
        -(((y + 0.05) / 0.02) ** 2)
    )
    shift[:, 1] = 0.0009 * np.tanh(x / 0.03) * np.exp(-((y / 0.05) ** 2)) + 0.0006 * np.tanh(
        x / 0.015
    ) * front * np.exp(-(((y + 0.088) / 0.015) ** 2))
    return shift


def on_ear(points: Points) -> np.ndarray:
    """1 on the ears, fading to 0 on the head."""
    alone = Sculpture()
    ears(alone)
    return step(alone.field(points), 0.0030, 0.0004)


def numbers(points: Points) -> dict[str, np.ndarray]:
    """Attributes, 0 to 1: where hair grows, how long, where brows and lashes grow."""
    x, y, z = points.T
    angle = np.degrees(np.arctan2(np.abs(x), z + 0.010))
    line = np.interp(angle, *np.array(HAIRLINE).T)
    slope = np.interp(angle, [0, 45, 60, 90, 120, 180], [1, 0.8, 0.6, 0.6, 0.7, 1])  # lines that run steeply
    above = (y - line) * slope
    scalp = step(above, -0.003, 0.009) * (1 - on_ear(points)) * step(y, -0.115, -0.085)
    across, along = from_stroke(points, BROW)
    ahead = step(z, 0.020, 0.035)
    lash, _ = from_stroke(points, [(a, b, 0.0013) for a, b in LID])
    return {
        "scalp": scalp,
        "length": scalp * (0.25 + 0.75 * step(above, 0.0, 0.030)),
        "brow": ahead * step(across, 1.1, 0.5) * step(along, -0.08, 0.12),
        "lash": ahead * step(lash, 1.6, 0.6),
    }


def colours(points: Points) -> np.ndarray:
    """Colours of the skin, uint8 in sRGB: lips, cheeks, ears and the tip of the nose redder, brows and lashes dark."""
    z = points[:, 2]
    ahead = step(z, 0.015, 0.045)
    found = np.tile(np.array([209.0, 159, 134]), (len(points), 1))
    found = mixed(found, (214, 170, 143), 0.6 * blob(points, (0, 0.035, 0.085), (0.05, 0.03, 0.03)))
    found = mixed(found, (203, 133, 111), 0.45 * blob(points, (0.043, -0.045, 0.062), (0.024, 0.020, 0.030)))
    found = mixed(found, (198, 126, 103), 0.55 * blob(points, (0, -0.056, 0.108), (0.014, 0.010, 0.020)))
    found = mixed(found, (200, 131, 107), 0.35 * blob(points, (0, -0.118, 0.092), (0.016, 0.010, 0.02)))
    found = mixed(found, (186, 124, 105), 0.45 * ahead * blob(points, (0.032, -0.016, 0.072), (0.016, 0.008, 0.02)))
    found = mixed(
        found,
        (196, 119, 95),
        0.60 * np.maximum(on_ear(points), blob(points, (0.070, -0.03, -0.011), (0.01, 0.014, 0.009))),
    )
    lips = [(x, y, w) for (x, y), w in zip(MOUTH, (0.0078, 0.0078, 0.0058, 0.0014), strict=True)]
    lower = [(0, -0.0905, 0.0072), (0.012, -0.0900, 0.0058), (0.0240, -0.0890, 0.0012)]
    red = np.maximum(step(from_stroke(points, lips)[0], 1.05, 0.72), step(from_stroke(points, lower)[0], 1.05, 0.75))
    found = mixed(found, (176, 94, 87), 0.75 * ahead * red)
    found = mixed(
        found, (120, 52, 50), 0.6 * ahead * step(from_stroke(points, [(*p, 0.0013) for p in MOUTH])[0], 1.4, 0.4)
    )
    across, along = from_stroke(points, BROW)
    lash, _ = from_stroke(points, [(*p, 0.0013) for p in LID])
    found = mixed(found, (100, 72, 56), 0.68 * ahead * step(across, 1.5, 0.2) * step(along, -0.15, 0.15))
    found = mixed(found, (70, 46, 38), 0.80 * ahead * step(lash, 1.6, 0.6))
    return np.clip(np.rint(found), 0, 255).astype(np.uint8)


def model() -> Model:
    """The head, ready to become a mesh."""
    return Model(head(), size, axes, pose, colours, numbers)


if __name__ == "__main__":
    command(__doc__, model(), "head.ply", spacing=0.0021)
