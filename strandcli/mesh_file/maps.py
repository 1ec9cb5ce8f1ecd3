"""Numbers all over a mesh: attributes of its vertices, or the brightness of a picture by its uv.

Textures are pictures with their halves, quarters and so on, each the mean of four pixels (Williams 1983, "Pyramidal
parametrics").
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common import srgb
from ..common.counted import counted
from ..common.rotations import turning
from ..errors import UsageError, about
from ..files.inputs import cached, content
from ..files.picture_samples import MOST, pixels
from ..meshes.mesh import TriangleMesh
from .read import KEPT, UP

LINEAR = srgb.decoded(np.arange(256) / 255.0).astype(np.float32)
"""(256,) linear light of the codes of sRGB."""


class Pyramid(NamedTuple):
    """A picture in levels, the whole one first."""

    texels: NDArray[np.uint8]
    """(n, 3) sRGB, row by row from the top, level after level."""
    levels: NDArray[np.int64]
    """(L, 3) the first texel of each level, its width and its height."""


def picture(path: str) -> NDArray[np.uint8]:
    """(h, w, 3) sRGB, the first row at the top. Raises `UsageError` for what is no picture."""
    with about("picture", path):
        try:
            return pixels(content(path))
        except ValueError:
            raise UsageError(
                f"{path}: is no picture that can be read, of up to {MOST:,} pixels; take a PNG or a JPEG"
            ) from None


def pyramid(image: NDArray[np.uint8]) -> Pyramid:
    """The levels of a picture (h, w, 3) down to one pixel."""
    light = LINEAR[image]
    parts, levels, first = [image.reshape(-1, 3)], [(0, image.shape[1], image.shape[0])], 0
    while max(light.shape[:2]) > 1:
        first += light.shape[0] * light.shape[1]
        light = _halved(_halved(light, 0), 1)
        parts.append(encoded(light).reshape(-1, 3))
        levels.append((first, light.shape[1], light.shape[0]))
    return Pyramid(np.ascontiguousarray(np.concatenate(parts)), np.array(levels, np.int64))


def _halved(light: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Means of pairs along an axis; of an odd number the last is in two halves."""
    count = light.shape[axis]
    if count == 1:
        return light
    even = np.take(light, range(0, count - 1, 2), axis)
    odd = np.take(light, range(1, count, 2), axis)
    found = np.float32(0.5) * (even + odd)
    if count % 2:
        tail = np.take(light, [count - 1], axis)
        last = np.take(found, [found.shape[axis] - 1], axis)
        found = np.concatenate([np.take(found, range(found.shape[axis] - 1), axis), (2 * last + tail) / 3], axis)
    return np.ascontiguousarray(found, np.float32)


def encoded(light: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Codes of sRGB whose light is nearest."""
    middles = 0.5 * (LINEAR[1:] + LINEAR[:-1])
    return np.searchsorted(middles, light).astype(np.uint8)


Floats = NDArray[np.float64]

COLOURS = "colour"
"""The name under which the vertices' colours are an attribute: their brightness."""
BRIGHTNESS = np.array([0.2126, 0.7152, 0.0722])
"""Of linear red, green and blue (Rec. 709)."""
TEXELS = 2.0
"""The longest edge of a piece in texels, at most: a picture is linear on a piece."""
MOST_PIECES = 1 << 22
"""From so many on pieces are not divided any more."""


class Place(NamedTuple):
    """Where a map is asked for, for the messages."""

    file: str
    """The mesh."""
    key: str
    """The setting that names the map."""


class Pieces(NamedTuple):
    """Parts of triangles on which a map is linear."""

    triangles: NDArray[np.int64]
    """(P,) the triangle of each."""
    corners: Floats
    """(P, 3, 3) barycentric coordinates of its corners in that."""
    values: Floats
    """(P, 3) the map at its corners."""


def is_picture(name: str) -> bool:
    """Whether a map's name is that of a picture, and not of an attribute."""
    return bool(Path(name).suffix)


def pieces(mesh: TriangleMesh, name: str, place: Place) -> Pieces:
    """The mesh in pieces on which a map is linear; whole triangles for an attribute, or without a name, which is 1
    everywhere. Raises `UsageError` for a map that there is not."""
    triangles = np.arange(len(mesh.triangles))
    corners = np.broadcast_to(np.eye(3), (len(triangles), 3, 3))
    if not name:
        return Pieces(triangles, corners, np.ones((len(triangles), 3)))
    if is_picture(name):
        grey, uv = _grey(name), _uv(mesh, name, place)
        triangles, corners = _divided(uv, grey.shape, triangles, corners)
        values = _sampled(grey, np.einsum("pck,pkd->pcd", corners, uv[triangles]).reshape(-1, 2)).reshape(-1, 3)
    else:
        values = numbers(mesh, name, place)[mesh.triangles]
    return Pieces(triangles, corners, values)


def lookup(
    mesh: TriangleMesh, name: str, place: Place, triangles: NDArray[np.integer[Any]], shares: Floats
) -> Floats:  # fmt: skip
    """(n,) a map at points of triangles (n,) with barycentric coordinates (n, 3). Raises `UsageError` for one that
    there is not."""
    if is_picture(name):
        found = _sampled(_grey(name), np.einsum("nk,nkd->nd", shares, _uv(mesh, name, place)[triangles]))
    else:
        found = np.einsum("nk,nk->n", shares, numbers(mesh, name, place)[mesh.triangles[triangles]])
    return np.asarray(found)


def numbers(mesh: TriangleMesh, name: str, place: Place) -> Floats:
    """(V,) a number for each vertex. Raises `UsageError`."""
    if name == COLOURS and mesh.colours is not None and name not in mesh.attributes:
        return np.asarray(mesh.colours.astype(np.float64) @ BRIGHTNESS)
    return _finite(_attribute(mesh, name, place, 1).reshape(-1), name, place)


def vectors(mesh: TriangleMesh, name: str, place: Place, up: str) -> Floats:
    """(V, 3) a vector for each vertex, turned as the mesh is by the up axis of its file. Raises `UsageError`."""
    return np.asarray(_finite(_attribute(mesh, name, place, 3), name, place) @ turning(up, UP).T)


def coloured(mesh: TriangleMesh, triangles: NDArray[np.integer[Any]], shares: Floats) -> NDArray[np.float32]:
    """(n, 3) linear colours at points of triangles (n,) with barycentric coordinates (n, 3): of the texture, whose
    texel is the nearest one, else of the vertices. The mesh has one of the two."""
    if mesh.texture is not None and mesh.uv is not None:
        height, width = mesh.texture.shape[:2]
        uv = np.einsum("nk,nkd->nd", shares, mesh.uv[triangles].astype(np.float64))
        row = np.floor((1.0 - uv[:, 1]) * height).astype(np.int64) % height
        column = np.floor(uv[:, 0] * width).astype(np.int64) % width
        return np.asarray(LINEAR[mesh.texture[row, column]])
    assert mesh.colours is not None
    return np.einsum("nk,nkc->nc", shares, mesh.colours[mesh.triangles[triangles]]).astype(np.float32)


def _attribute(mesh: TriangleMesh, name: str, place: Place, many: int) -> Floats:
    found = mesh.attributes.get(name)
    if found is None and many == 3 and all(f"{name}_{c}" in mesh.attributes for c in "xyz"):
        found = np.stack([mesh.attributes[f"{name}_{c}"].reshape(-1) for c in "xyz"], axis=1)
    if found is None:
        known = sorted({*mesh.attributes, *([COLOURS] if mesh.colours is not None else [])})
        there = f"there are {', '.join(known)}" if known else "it has none (.ply files may have some)"
        raise UsageError(f"{place.file}: {place.key}: no attribute {name!r} of its vertices; {there}")
    values = np.asarray(found, np.float64).reshape(len(found), -1)
    if values.shape[1] != many:
        raise UsageError(
            f"{place.file}: {place.key}: the attribute {name!r} has {counted(values.shape[1], 'number')} a vertex, "
            f"not {many}"
        )
    return values


def _finite(values: Floats, name: str, place: Place) -> Floats:
    if not np.isfinite(values).all():
        raise UsageError(
            f"{place.file}: {place.key}: the attribute {name!r} is not finite everywhere; mend it in its program"
        )
    return values


def _uv(mesh: TriangleMesh, name: str, place: Place) -> Floats:
    if mesh.uv is None:
        raise UsageError(
            f"{place.file}: {place.key}: has no texture coordinates, by which {Path(name).name} would lie on it; "
            "take an attribute, or a mesh with uv"
        )
    uv = mesh.uv.astype(np.float64)
    if not np.isfinite(uv).all():
        raise UsageError(f"{place.file}: {place.key}: its texture coordinates are not finite; mend it in its program")
    return uv


@cached(KEPT)
def _grey(file: str) -> Floats:
    """(h, w) the codes of a picture over 255, weighted by brightness: what it says, not the light that it shows."""
    return np.asarray(picture(file).astype(np.float64) @ BRIGHTNESS / 255.0)


def _sampled(grey: Floats, uv: Floats) -> Floats:
    """(n,) a picture at uv (n, 2), linear between the middles of its texels, repeated."""
    height, width = grey.shape
    x, y = uv[:, 0] * width - 0.5, (1.0 - uv[:, 1]) * height - 0.5
    left, top = np.floor(x), np.floor(y)
    a, b = x - left, y - top
    i, j = left.astype(np.int64) % width, top.astype(np.int64) % height
    k, m = (i + 1) % width, (j + 1) % height
    upper = (1 - a) * grey[j, i] + a * grey[j, k]
    return np.asarray((1 - b) * upper + b * ((1 - a) * grey[m, i] + a * grey[m, k]))


def _divided(
    uv: Floats, shape: tuple[int, ...], triangles: NDArray[np.int64], corners: Floats
) -> tuple[NDArray[np.int64], Floats]:
    """Triangles, each divided in four as long as an edge of a piece spans more than `TEXELS`."""
    pixels = uv * (shape[1], shape[0])
    longest = np.linalg.norm(np.roll(pixels, -1, axis=1) - pixels, axis=2).max(axis=1)
    levels = np.ceil(np.log2(np.maximum(longest / TEXELS, 1.0))).astype(np.int64)
    while levels.max() > 0 and (4 ** levels.astype(np.float64)).sum() > MOST_PIECES:
        levels = np.minimum(levels, levels.max() - 1)
    found, done = [], []
    for level in range(int(levels.max()) + 1):
        ready = levels[triangles] == level
        found.append(triangles[ready])
        done.append(corners[ready])
        triangles, corners = np.repeat(triangles[~ready], 4), _quartered(corners[~ready])
    return np.concatenate(found), np.concatenate(done)


def _quartered(corners: Floats) -> Floats:
    """(4 P, 3, 3) the quarters of pieces (P, 3, 3)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    four = [np.stack(one, axis=1) for one in ((a, ab, ca), (ab, b, bc), (ab, bc, ca), (ca, bc, c))]
    return np.stack(four, axis=1).reshape(-1, 3, 3)
