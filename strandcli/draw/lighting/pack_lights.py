"""Packing of lights for kernels."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.model import DirectionalLight, Light
from ..common.kernels.light_columns import COLUMNS
from ..shadows.shadow import ShadowMaps
from ..shadows.shadow_model import shades_vertices
from ..view.camera import View, ball


def pack_lights(lights: tuple[Light, ...], maps: ShadowMaps | None, bounds: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return (n, `light_columns.COLUMNS`) float32, one row for each light that emits light."""
    rows: list[list[Any]] = []
    traced = 0
    for i, light in enumerate(lights):
        if light.intensity <= 0 or not any(light.colour):
            continue
        if isinstance(light, DirectionalLight):
            away = -np.array(light.direction, np.float64)
            where = away / np.linalg.norm(away)
        else:
            where = np.array(light.position)
        first, count = maps.owners[i] if maps is not None else (0, 0)
        bias = light.shadow.bias
        layers = maps.layers[first] if count and maps is not None else 0
        if count and maps is not None and bias == 0 and layers == 0:
            # an opacity map needs no bias: a strand's own contribution is subtracted
            bias = default_bias(maps.views[first], bounds)
        power = np.array(light.colour) * light.intensity
        kind = float(not isinstance(light, DirectionalLight))
        traced += shades_vertices(light)
        number = traced if shades_vertices(light) else 0
        width, over = (maps.thickness.mean, maps.over) if maps is not None else (0.0, 0.0)
        rows.append([kind, *where, *power, first, count, bias, layers, number, _size(light), width, over, 0.0])
    return np.array(rows, np.float32).reshape(-1, COLUMNS)


def default_bias(view: View, bounds: NDArray[np.float64]) -> float:
    """Return the depth bias of a min/max map, metres: the size of a texel at the groom's centre."""
    centre, radius = ball(bounds)
    depth = max(float(np.linalg.norm(centre - view.eye)), radius) if view.perspective else 1.0
    return depth / view.focal


def _size(light: Light) -> float:
    """Return the sine of a directional light's angular radius, or the radius of a point light in metres."""
    return math.sin(math.radians(light.size / 2)) if isinstance(light, DirectionalLight) else light.size / 2
