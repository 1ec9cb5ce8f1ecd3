"""How far two pictures are apart to the eye that sees one in place of the other: ꟻLIP, for pictures of 8 bits.

Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020, "ꟻLIP: A Difference Evaluator for
Alternating Images", Proceedings of the ACM on Computer Graphics and Interactive Techniques 3 (2); numbers of equations
and sections are those of that paper. Contrast sensitivity: Johnson and Fairchild 2003; colour distance: Abasi et al.
2020 (HyAB); adjustment of chroma: Hunt 1977.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MismatchError
from .png import Rgb, linear_light, over

Array = NDArray[np.float64]

PIXELS_A_DEGREE = 0.7 * (3840 / 0.7) * math.pi / 180
"""Where the eye is .7 m from a screen of 3,840 pixels on .7 m: what the paper supposes."""
TO_XYZ = np.array(
    [
        [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
        [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
        [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
    ]
)
"""Linear sRGB to XYZ, with the primaries and the white (D65) of IEC 61966-2-1."""
WHITE = TO_XYZ.sum(1)
SENSITIVITY = (((1.0, 0.0047),), ((1.0, 0.0053),), ((34.1, 0.04), (13.5, 0.025)))
"""Of achromatic, red-green and blue-yellow channel: a and b of Gaussians a √(π / b) exp(−π² x² / b), x in degrees
(table 1)."""
FEATURE = 0.082
"""Width of edges and points that are looked for, degrees (section 4.2)."""
Q_COLOUR, Q_FEATURE, P_COLOUR, P_TARGET = 0.7, 0.5, 0.4, 0.95
"""Exponents of the differences of colour and of features; the share of the greatest difference of colours below which
differences take up ``P_TARGET`` of the range (sections 4.1 to 4.3)."""
BAND = 1 << 21
"""Pixels that are worked on at once, about."""


def flip(first: NDArray[Any], second: NDArray[Any], pixels_a_degree: float = PIXELS_A_DEGREE) -> Array:
    """Return the difference (height, width), 0 to 1, of two sRGB pictures (height, width, 3 or more) uint8, or floats
    from 0 to 255; channels after the third do not count. Raises `MismatchError` where their sizes differ."""
    if first.shape[:2] != second.shape[:2]:
        raise MismatchError(
            f"sizes differ: {first.shape[1]}x{first.shape[0]} against {second.shape[1]}x{second.shape[0]}"
        )
    height, width = first.shape[:2]
    reach = max(_reach_of_colour(pixels_a_degree), math.ceil(1.5 * FEATURE * pixels_a_degree))
    rows = max(BAND // max(width, 1), 1)
    out = np.empty((height, width))
    for top in range(0, height, rows):
        low, high = max(top - reach, 0), min(top + rows + reach, height)
        pair = [_opponent(linear_light(picture[low:high, :, :3])) for picture in (first, second)]
        found = _difference(pair[0], pair[1], pixels_a_degree)
        out[top : top + rows] = found[top - low : top - low + rows]
    return out


def mean_flip(first: NDArray[Any], second: NDArray[Any]) -> float:
    """Return the mean of `flip` over a picture, at the usual distance of the eye; with alpha, over black or white,
    whichever shows more."""
    if first.shape[2:] != (4,):
        return float(flip(first, second).mean())
    grounds: tuple[Rgb, ...] = ((0, 0, 0), (255, 255, 255))
    pairs = ([over(np.rint(one).astype(np.uint8), ground) for one in (first, second)] for ground in grounds)
    return max(float(flip(one, two).mean()) for one, two in pairs)


def _difference(first: Array, second: Array, density: float) -> Array:
    """Return the difference of two pictures in opponent colours: that of colours, raised where features differ
    (equation 15)."""
    features = _feature_difference(first[..., 0], second[..., 0], density)
    return np.asarray(_colour_difference(first, second, density) ** (1 - features))


def _colour_difference(first: Array, second: Array, density: float) -> Array:
    """Return the difference of colours, 0 to 1, as it is seen from a distance (section 4.1)."""
    seen = [_adjusted(np.clip(_rgb(_blurred(one, density)), 0, 1)) for one in (first, second)]
    apart = _apart(seen[0], seen[1]) ** Q_COLOUR
    green, blue = (_adjusted(np.array(colour)) for colour in ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]))
    most = _apart(green, blue) ** Q_COLOUR
    knee = P_COLOUR * most
    above = P_TARGET + (apart - knee) / (most - knee) * (1 - P_TARGET)
    return np.asarray(np.clip(np.where(apart < knee, P_TARGET / knee * apart, above), 0, 1))


def _apart(first: Array, second: Array) -> Array:
    """Return the HyAB distance of colours (…, 3): of lightness, and Euclidean of chroma (equation 8)."""
    off = first - second
    return np.asarray(np.abs(off[..., 0]) + np.hypot(off[..., 1], off[..., 2]))


def _feature_difference(first: Array, second: Array, density: float) -> Array:
    """Return the difference of edges and points, 0 to 1, of two achromatic channels (section 4.2)."""
    sigma = 0.5 * FEATURE * density
    x = np.arange(-math.ceil(3 * sigma), math.ceil(3 * sigma) + 1, dtype=np.float64)
    bell = np.exp(-(x**2) / (2 * sigma**2))
    worst: Array = np.zeros(first.shape)
    for weights in (-x * bell, (x**2 / sigma**2 - 1) * bell):
        across = np.where(weights > 0, weights / weights[weights > 0].sum(), weights / -weights[weights < 0].sum())
        sizes = [
            np.hypot(_filtered(y, across, bell / bell.sum()), _filtered(y, bell / bell.sum(), across))
            for y in ((first + 16) / 116, (second + 16) / 116)
        ]
        worst = np.maximum(worst, np.abs(sizes[0] - sizes[1]))
    return np.asarray((worst / math.sqrt(2)) ** Q_FEATURE)


def _reach_of_colour(density: float) -> int:
    """Return the radius of the filters of contrast sensitivity, pixels."""
    widest = max(b for parts in SENSITIVITY for _, b in parts)
    return math.ceil(3 * math.sqrt(widest / (2 * math.pi**2)) * density)


def _blurred(picture: Array, density: float) -> Array:
    """Return a picture in opponent colours (height, width, 3) as a contrast sensitivity leaves it (equation 4)."""
    reach = _reach_of_colour(density)
    x = np.arange(-reach, reach + 1) / density
    channels = []
    for channel, parts in enumerate(SENSITIVITY):
        bells = [np.exp(-(math.pi**2) * x**2 / b) for _, b in parts]
        weights = [a * math.sqrt(math.pi / b) for a, b in parts]
        whole = sum(weight * bell.sum() ** 2 for weight, bell in zip(weights, bells, strict=True))
        made = [
            weight / whole * _filtered(picture[..., channel], bell, bell)
            for weight, bell in zip(weights, bells, strict=True)
        ]
        channels.append(sum(made[1:], made[0]))
    return np.stack(channels, -1)


def _filtered(channel: Array, across: Array, down: Array) -> Array:
    """Return a channel (height, width) filtered by ``across`` along its rows and ``down`` along its columns, each of an
    odd number of weights; beyond a side its pixels go on."""
    return _along(_along(channel, across, 1), down, 0)


def _along(channel: Array, weights: Sequence[float] | Array, axis: int) -> Array:
    reach = len(weights) // 2
    width = channel.shape[axis]
    padded = np.pad(channel, [(reach, reach) if one == axis else (0, 0) for one in (0, 1)], mode="edge")
    out = np.zeros(channel.shape)
    for place, weight in enumerate(weights):
        part = slice(place, place + width)
        out += weight * (padded[part] if axis == 0 else padded[:, part])
    return out


def _opponent(rgb: Array) -> Array:
    """Return linear RGB as Y_y, C_x and C_z, a linear form of CIELAB (equation 2)."""
    x, y, z = np.moveaxis(rgb @ TO_XYZ.T / WHITE, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1)


def _rgb(opponent: Array) -> Array:
    """Return linear RGB of `_opponent`."""
    y = (opponent[..., 0] + 16) / 116
    xyz = np.stack([y + opponent[..., 1] / 500, y, y - opponent[..., 2] / 200], -1)
    return np.asarray((xyz * WHITE) @ np.linalg.inv(TO_XYZ).T)


def _adjusted(rgb: Array) -> Array:
    """Return linear RGB as CIELAB whose chroma is scaled with lightness (equation 7)."""
    ratio = rgb @ TO_XYZ.T / WHITE
    knee = 6 / 29
    f = np.where(ratio > knee**3, np.cbrt(ratio), ratio / (3 * knee**2) + 4 / 29)
    light = 116 * f[..., 1] - 16
    hue = [0.01 * light * 500 * (f[..., 0] - f[..., 1]), 0.01 * light * 200 * (f[..., 1] - f[..., 2])]
    return np.stack([light, *hue], -1)
