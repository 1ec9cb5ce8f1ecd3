"""A sitting fox to grow fur on, as `presets/meshes/fox.ply`. Metres, y up, facing +z, on the ground y = 0.

python examples/meshes/fox.py                             # writes presets/meshes/fox.ply, in a minute
python examples/meshes/fox.py sketch.ply --coarser 2      # with a quarter of the triangles
"""

from __future__ import annotations

import numpy as np
from fox_shape import EAR, EYE, MOUTH, NOSE, TAIL, fox
from model import Model, Points, blob, command, graded, mixed, step
from sculpt import smooth_curve
from surface import unit

SCULPTURE = fox()


def axes(spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates of the grid: fine at the head."""
    return (
        graded(-0.13, 0.23, (-0.080, 0.080), spacing, 2 * spacing),
        graded(-0.02, 0.50, (0.300, 0.490), spacing, 2 * spacing),
        graded(-0.22, 0.21, (0.000, 0.195), spacing, 2 * spacing),
    )


def size(points: Points) -> np.ndarray:
    """Wanted length of edges: short at eyes, nose, mouth, ears and paws."""
    there = np.column_stack([np.abs(points[:, 0]), points[:, 1:]])
    found = np.full(len(points), 0.0104)
    for centre, reach, wanted in (
        ((0, 0.360, 0.100), (0.060, 0.060, 0.090), 0.0062),
        ((0, 0.336, 0.165), (0.016, 0.016, 0.025), 0.0026),
        (EYE, (0.014, 0.013, 0.014), 0.0018),
        ((0.050, 0.440, 0.050), (0.024, 0.044, 0.024), 0.0046),
        ((0.056, 0.020, 0.080), (0.045, 0.022, 0.036), 0.0054),
    ):
        far = np.linalg.norm((there - centre) / np.asarray(reach), axis=1)
        found = np.minimum(found, wanted + 0.012 * step(far, 1, 2.4))
    return found


def pose(points: Points) -> Points:
    """Displacement in the end: none, since the tail makes it uneven enough."""
    return np.zeros_like(points)


def along(points: Points, curve: list[tuple[float, float, float, float]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the nearest place on a curve: distance over radius, how far along it (0 to 1), and its direction."""
    knots = smooth_curve(np.asarray(curve), 8)
    gap = np.linalg.norm(points[:, None] - knots[:, :3], axis=2)
    nearest = gap.argmin(1)
    tangent = unit(np.gradient(knots[:, :3], axis=0))
    return gap[np.arange(len(points)), nearest] / knots[nearest, 3], nearest / (len(knots) - 1), tangent[nearest]


def parts(points: Points) -> dict[str, np.ndarray]:
    """Where there is what, 0 to 1."""
    x, y, z = points.T
    right = np.column_stack([np.abs(x), y, z])
    tail, far, _ = along(points, TAIL)
    ear, up, _ = along(right, EAR)
    tail = step(tail, 1.7, 1.1) * step(far, 0.05, 0.22)
    ear = step(ear, 2.2, 1.3) * step(y, 0.392, 0.412)
    eye = np.linalg.norm(right - EYE, axis=1)
    return {
        "tail": tail, "tip": tail * step(far, 0.66, 0.80), "ear": ear, "ear_tip": ear * step(up, 0.25, 0.8),
        "eye": step(eye, 0.0119, 0.0110),
        "rim": step(eye, 0.0139, 0.0121),
        "lids": step(eye, 0.0172, 0.0125),
        "nose": step(np.linalg.norm((points - NOSE) / (0.0104, 0.0080, 0.0085), axis=1), 1.25, 0.95),
        "mouth": step(along(right, [(*p, 0.0024) for p in MOUTH])[0], 1.9, 0.9),
        "muzzle": step(z, 0.095, 0.135) * step(y, 0.29, 0.31),
        "face": step(z, 0.060, 0.100) * step(y, 0.315, 0.340),
        "head": step(y, 0.300, 0.345) * (1 - tail),
        "legs": np.maximum(
            step(y, 0.165, 0.105) * step(z, 0.040, 0.052) * step(np.abs(x), 0.062, 0.054),
            step(y, 0.045, 0.025) * step(z, 0.0, 0.03),
        ) * (1 - tail),
        "paws": step(y, 0.050, 0.030) * step(z, 0.020, 0.045) * (1 - tail),
        "chest": step(z - 0.25 * (y - 0.2), 0.035, 0.062) * step(y, 0.110, 0.170) * step(y, 0.330, 0.300)
        * step(np.abs(x), 0.060, 0.030),
        "cheek": blob(points, (0.058, 0.338, 0.078), (0.024, 0.022, 0.030)),
    }  # fmt: skip


def comb(points: Points, is_: dict[str, np.ndarray]) -> np.ndarray:
    """Unit directions of growth along the surface: from the nose back, down the body, along tail, ears and legs."""
    x, _, _ = points.T
    right = np.column_stack([np.abs(x), points[:, 1:]])
    side = np.column_stack([np.sign(x), np.ones_like(x), np.ones_like(x)])
    from_nose = unit(points - (0, 0.345, 0.200))
    wanted = np.tile([0.0, -0.9, -0.45], (len(points), 1))
    wanted = mixed(wanted, (0, -1, 0.1), is_["chest"])
    wanted += is_["head"][:, None] * (from_nose + np.array([0, -0.15, -0.35]) - wanted)
    wanted += is_["ear"][:, None] * (along(right, EAR)[2] * side - wanted)
    wanted += is_["tail"][:, None] * (along(points, TAIL)[2] - wanted)
    wanted = mixed(wanted, (0, -1, 0.15), is_["legs"])
    wanted = mixed(wanted, (0, -0.3, 1), is_["paws"])
    normal = unit(SCULPTURE.gradient(points))
    return unit(wanted - normal * (normal * wanted).sum(1, keepdims=True))


def numbers(points: Points) -> dict[str, np.ndarray]:
    """Attributes: density and length of the fur, 0 to 1, and the direction in which it grows along the surface."""
    is_ = parts(points)
    bare = np.maximum.reduce([is_["eye"], is_["nose"], 0.85 * is_["mouth"] * is_["muzzle"]])
    density = (1 - bare) * step(points[:, 1], 0.001, 0.006)
    length = np.full(len(points), 0.50)
    for part, value in (("chest", 0.85), ("head", 0.45), ("cheek", 0.80), ("face", 0.20), ("muzzle", 0.11),
                        ("lids", 0.10), ("ear", 0.18), ("ear_tip", 0.12), ("legs", 0.17), ("paws", 0.12),
                        ("tail", 1.0)):  # fmt: skip
        length += is_[part] * (value - length)
    direction = comb(points, is_)
    return {"density": density, "length": length, **{f"comb_{a}": direction[:, i] for i, a in enumerate("xyz")}}


def colours(points: Points) -> np.ndarray:
    """Colours of the coat and of the skin, uint8 in sRGB: rust, white below, black socks and ears, a white tip."""
    x, y, z = points.T
    is_ = parts(points)
    found = np.tile(np.array([204.0, 106, 44]), (len(points), 1))
    found = mixed(found, (150, 70, 32), 0.8 * step(z + 0.35 * y, 0.06, -0.03) * step(np.abs(x), 0.06, 0.015))
    found = mixed(found, (226, 130, 58), 0.6 * is_["head"] * (1 - is_["face"]))
    white = (246, 238, 226)
    found = mixed(found, white, is_["chest"])
    under = step(y + 0.20 * np.maximum(z - 0.09, 0) - 0.10 * np.abs(x), 0.349, 0.340) * is_["head"]
    found = mixed(found, white, under * step(z, 0.040, 0.065))
    found = mixed(found, white, 0.45 * blob(points, (0.016, 0.386, 0.112), (0.008, 0.007, 0.02)))
    found = mixed(found, (60, 34, 24), 0.55 * blob(points, (0.0125, 0.348, 0.150), (0.006, 0.006, 0.022)))
    found = mixed(found, white, is_["tip"])
    inner = is_["ear"] * step(SCULPTURE.gradient(points)[:, 2], 0.25, 0.6) * step(z, 0.040, 0.052)
    found = mixed(found, (38, 26, 22), is_["ear_tip"] * (1 - inner))
    found = mixed(found, (238, 214, 190), 0.9 * inner)
    found = mixed(found, (40, 27, 22), is_["legs"] * step(y, 0.120, 0.085))
    found = mixed(found, (226, 136, 66), 0.6 * is_["lids"])  # the lid faces down and lies in shade
    found = mixed(found, (46, 28, 22), 0.9 * is_["rim"])
    found = mixed(found, (24, 13, 9), is_["eye"])
    look = unit(np.column_stack([np.abs(x), y, z]) - EYE) @ unit(np.array([0.36, 0.04, 0.93]))
    found = mixed(found, (176, 98, 24), is_["eye"] * step(look, 0.56, 0.66))
    found = mixed(found, (14, 9, 7), is_["eye"] * step(look, 0.80, 0.88))
    found = mixed(found, (22, 18, 18), np.maximum(is_["nose"], 0.9 * is_["mouth"] * is_["muzzle"]))
    return np.clip(np.rint(found), 0, 255).astype(np.uint8)


def model() -> Model:
    """The fox, ready to become a mesh."""
    return Model(SCULPTURE, size, axes, pose, colours, numbers)


if __name__ == "__main__":
    command(__doc__, model(), "fox.ply", spacing=0.0036)
