"""Estimates of the peak memory of a run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ..common.registry import FIBRES
from ..constants import (
    BAND_VERTICES,
    BANDS,
    BATCH_VERTICES,
    FILE_POINTS,
    FRAGMENTS,
    LAYER_ROOM,
    PART_BYTES,
    SORTED_BYTES,
    SORTED_POINTS,
    SORTING_BYTES,
    W,
)
from ..draw.shadows.shadow_model import ShadowModel, casts_map, counts_strands, model_of, needs_counts, shades_vertices
from ..scene.model import MeshShape
from ..scene.model.emitter import TIED
from ..simulate.rod import needs_double, shortest_segment
from .sizes import grid_bytes, map_rows, pairs_of, share_in_maps, side_of

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .make import Plan
    from .sizes import Sizes

RESIDENT, UNDRAWN = 173_500_000, 18_000_000
"""Bytes of a process that draws a plain scene, without the scene, and less where nothing is drawn: 57 million of the
interpreter, of what libraries hold and of kernels; the rest are libraries' files, most of it LLVM's, of which a system
maps 60 million less or more by how its page cache holds them."""
SORTING, RODS, CHILDREN, MESHES = 10_000_000, 8_000_000, 5_000_000, 25_000_000
"""Of the further kernels, and of what reads meshes, where a scene has them."""


MOMENTS = 4
"""Of a file that moves, what is in memory beside the first moment."""
PARTS, PART = 4, 48
"""Of a strand in an opacity map, as in `draw.shadows.kernels.map_parts`."""
TILE, FULLEST = 1024, 4.0
"""Samples of a tile; how many times as many fragments the fullest tile has as those that strands are in have on
average."""
WAITING = 24
"""Bytes of a pixel of pictures that wait to be written."""
LEFT = 12
"""Bytes of a vertex that are left over from the picture before, in an array that is too small for any in light."""
ROD, CROWDED, FRAMED = 80, 66, 16
"""Bytes of a particle of a rod, more where strands push each other, and more where strands have frames: twist, and
rest shapes in them."""
DOUBLE, DOUBLE_CROWDED = 88, 25
"""Bytes of a particle more in double precision, where those of frames are twice as many: the state's numbers, 64, and
positions beside those in single precision, 24; and where strands push each other, with what moves the grid."""
TOUCHING, PAIR = 290, 50
"""More where strands have contact: the state before the step, 120; particles at its ends, 48, boxes as they are and
sorted, 122; of a pair of segments whose boxes meet, its numbers and what sorts them."""


def memory_of(plan: Plan, scene: Scene, draw: bool) -> int:
    """Return the peak bytes of the process, with one frame drawn at a time."""
    total = program_bytes(scene, draw) + motion_bytes(plan, scene) + _mesh_bytes(scene)
    return total + (picture_bytes(plan, scene) if draw else plan.strands * scene.emitter.particles * 24)


def program_bytes(scene: Scene, draw: bool = True) -> int:
    """Return the bytes of the program, its libraries and kernels."""
    meshes = isinstance(scene.emitter.shape, MeshShape) or any(solid.kind == "mesh" for solid in scene.solids)
    total = RESIDENT if draw else RESIDENT - UNDRAWN
    total += SORTING if draw and scene.image.resolver != "zbuffer" else 0
    total += RODS if scene.solver == "rod" else 0
    total += CHILDREN if draw and scene.children is not None else 0
    return total + (MESHES if meshes else 0)


def motion_bytes(plan: Plan, scene: Scene) -> int:
    """Return the bytes of the strands that are simulated."""
    n = scene.emitter.particles
    blocks = -(-plan.strands // W) * W
    rods = _rod_bytes(scene) if scene.solver == "rod" else 0
    contact = rods and any(use.name == "contact" for use in scene.rules)
    touching = blocks * n * TOUCHING + PAIR * pairs_of(scene, plan.strands) if contact else 0
    # the state, the emitted groom, and the float64 work of one row while strands are emitted
    own = blocks * (12 * (n + 3) + 4 + 32 + 160 + rods * n) + round(touching) + grid_bytes(scene, plan.strands)
    return own + (_moments_bytes(scene) if scene.emitter.moving else 0)


def _moments_bytes(scene: Scene) -> int:
    """Bytes of a file that moves: two moments, one between them, and that packed."""
    emitter, followers = scene.emitter, scene.emitter.followers
    points = emitter.strands * emitter.particles if followers is None else followers.strands * followers.file_points
    return MOMENTS * 12 * points


def _rod_bytes(scene: Scene) -> int:
    """Return the bytes of a particle of rods, but for those of contact."""
    double = needs_double(scene, shortest_segment(scene.emitter))
    total = ROD + (DOUBLE if double else 0)
    if any(use.name == "interaction" for use in scene.rules):
        total += CROWDED + (DOUBLE_CROWDED if double else 0)
    return total + (FRAMED * (1 + double) if scene.rod.rest == "sag_free" else 0)


def _mesh_bytes(scene: Scene) -> int:
    """Bytes of solids that are meshes: triangles, trees and grids of distances."""
    meshes = [solid for solid in scene.solids if solid.kind == "mesh"]
    if not meshes:
        return 0
    from ..mesh_file.needs import whole_bytes

    return sum(whole_bytes(solid) for solid in meshes)


def picture_bytes(plan: Plan, scene: Scene) -> int:
    """Return the bytes for drawing one frame."""
    sizes = plan.sizes
    assert sizes is not None
    strands = sizes.made
    vertices = round(sizes.segments) + strands
    if not any(shades_vertices(light) for light in scene.lights):
        if scene.image.resolver == "zbuffer":
            vertices = min(vertices, BATCH_VERTICES + vertices // max(strands, 1) * W)
        elif strands * sizes.points > (
            SORTED_POINTS if scene.emitter.groom is None else FILE_POINTS
        ):  # a batch, and a band, with what is beside it
            vertices = min(vertices, BAND_VERTICES + 2 * max(BAND_VERTICES, vertices // BANDS))
    # in the world, how far along their strands they stand, which direction these have
    total = vertices * {"adaptive": 16, "thinned": 28}.get(scene.curves.mode, 12)
    total += _turns_bytes(plan, scene, vertices)
    total += strands * (8 + 8 + 2 * (sizes.points - 1) + 4 + 8 + 8)
    tables = getattr(FIBRES[scene.material.model], "memory", lambda material: 0)
    total += tables(scene.material)
    return total + _groom_bytes(plan, scene) + _light_bytes(plan, scene, vertices)


def _turns_bytes(plan: Plan, scene: Scene, vertices: int) -> int:
    """Return the bytes of strands as they are made, of vertices in light, and of a picture and vertices in it, which
    take memory in turns; of a later picture what is on the film is there from the one before."""
    assert plan.sizes is not None
    sorts = scene.image.resolver != "zbuffer"
    wide = sorts or scene.material.width * plan.sizes.scale > 1
    # on the screen, colours, marks; widths
    shown = vertices * (25 + (4 if wide and scene.material.width > 0 else 0)) + _sorting_bytes(plan, scene)
    in_light, film = round(vertices * _projected_bytes(plan, scene)), _film_bytes(plan, scene, vertices)
    made = _made_bytes(plan, scene)
    if not sorts:  # batches are cut from what is made
        return made + max(in_light, shown) + film
    once = plan.frames == 1 and scene.camera.aperture == 0 and scene.camera.shutter == 0
    if once:
        return max(made, in_light, shown + film)
    return max(made, in_light, shown) + film + (LEFT * vertices if in_light > shown else 0)


def _sorting_bytes(plan: Plan, scene: Scene) -> int:
    """Return the bytes in which the fragments of the fullest tile are sorted."""
    sizes = plan.sizes
    assert sizes is not None
    if scene.image.resolver == "zbuffer":
        return 0
    across = 2 * sizes.radius * sizes.scale
    width, height = (scene.image.supersample * pixels for pixels in scene.image.drawn)
    tiles = max(min(across, width) * min(across, height) / TILE, 1.0)
    return round(SORTING_BYTES * min(FULLEST * sizes.fragments / tiles, sizes.fragments / layers_of(sizes)))


def _projected_bytes(plan: Plan, scene: Scene) -> float:
    """Return the bytes for a vertex of what a light sees at once, at the most; 0 without shadow maps."""
    assert plan.sizes is not None
    found = 0.0
    segments = plan.sizes.segments / max(plan.sizes.made, 1)
    parts = (22 + 36 * min(segments / PART, PARTS - 1)) / (segments + 1)  # lists of them, and room for their ends
    for light in scene.lights:
        if casts_map(light, needs_counts(scene)):
            share = share_in_maps(scene, plan.sizes, side_of(scene, plan.sizes, light))
            deep = 28 * share + parts
            found = max(found, deep if counts_strands(light) else 12 * share)
    return found


def _groom_bytes(plan: Plan, scene: Scene) -> int:
    """Return the bytes of what children and a file's strands are made of."""
    assert plan.sizes is not None
    strands, n = plan.sizes.strands, plan.sizes.points
    total = 0
    if scene.children is not None:  # the guides as finely, and what strands follow
        total += 12 * (n + 1) * plan.strands + _followed_bytes(plan, scene)
    followers = scene.emitter.followers
    if followers is not None:  # the file, as it is read and packed; at rest, with shares; a table
        total += followers.strands * (24 * (followers.file_points + 1) + 100)
        total += strands * (16 * n + 100) + plan.strands * 200 * scene.emitter.particles
    return total


def _made_bytes(plan: Plan, scene: Scene) -> int:
    """Return the bytes of children, of a file's strands, and of tied strands."""
    assert plan.sizes is not None
    strands, n = plan.sizes.strands, plan.sizes.points
    total = 0
    if scene.children is not None:
        total += 12 * (n + 1) * plan.sizes.made * 9 // 8
    if scene.emitter.followers is not None:  # as they are placed
        total += strands * 12 * n * 9 // 8
    if scene.emitter.tie is not None:  # as they are made, in blocks, and joined to what hangs from the tie
        total += strands * 12 * (2 * (TIED + 1) + n)
    return total


def _followed_bytes(plan: Plan, scene: Scene) -> int:
    """Return the bytes of what children follow."""
    if scene.children is None or plan.sizes is None:
        return 0
    return plan.sizes.strands * (200 + 8 * len(scene.children.clumps) + 12 * len(scene.children.waves))


def shared_bytes(plan: Plan, scene: Scene) -> int:
    """Return the bytes of `picture_bytes` that frames drawn at once have in common: what children follow, and pictures
    that are written one after the other."""
    return _followed_bytes(plan, scene) + WAITING * plan.pixels


def _light_bytes(plan: Plan, scene: Scene, vertices: int) -> int:
    """Return the bytes of ambient occlusion, shadow maps and shadows at vertices."""
    total = int(sum(model_of(light).vertex_bytes(vertices) for light in scene.lights if shades_vertices(light)))
    if scene.occluded and scene.ambient_occlusion is not None:
        total += scene.ambient_occlusion.cells * (44 + scene.ambient_occlusion.directions)
    counts = needs_counts(scene)
    for one in scene.lights:
        if casts_map(one, counts):
            total += _map_bytes(plan, scene, one)
    return total


def _map_bytes(plan: Plan, scene: Scene, light: Any) -> int:
    """Return the bytes of a light's maps."""
    assert plan.sizes is not None
    model, views = model_of(light), 1 if light.kind == "directional" else 6
    side, layers = model.side_of(light.shadow), model.layers(light.shadow)
    if type(model).map_bytes is not ShadowModel.map_bytes:  # one from elsewhere, that knows
        return int(model.map_bytes(light.shadow, light.kind == "directional"))
    if not layers:
        return 8 * side**2 * views
    found, rows = map_rows(scene, plan.sizes, side, light.shadow.texel)
    return int(14 * found**2 + 16 * rows * (layers + 1)) * views


def _film_bytes(plan: Plan, scene: Scene, vertices: int) -> int:
    """Return the bytes of fragments, samples and pixels."""
    total = 0
    if scene.image.resolver != "zbuffer":  # each pixel has a list and the solids' depth; vertices are marked twice
        total += fragment_bytes(plan) + plan.samples * 12 + vertices
    if scene.image.haze is not None:  # the picture before solids are lit
        total += plan.samples * 12
    if scene.image.has_alpha:  # transmittance, of samples, vertices and their mean
        total += 12 * (plan.samples * (1 + (scene.image.haze is not None)) + vertices) + 60 * plan.pixels
    if scene.camera.shutter > 0:  # the frame before, and the moment between
        total += 2 * plan.strands * 12 * (scene.emitter.particles + 1)
    if scene.camera.aperture > 0 or scene.camera.shutter > 0:
        total += plan.samples * (24 if scene.image.has_alpha else 12)
    if scene.image.aovs:
        total += plan.pixels * 60
    return total + plan.samples * 32 + plan.pixels * WAITING


def layers_of(sizes: Sizes) -> int:
    """Return in how many layers sorted fragments go through."""
    return max(math.ceil(LAYER_ROOM * sizes.fragments / FRAGMENTS), 1)


def fragment_bytes(plan: Plan) -> int:
    """Return the bytes of sorted fragments in memory at once: pages of the room for them that are written to."""
    assert plan.sizes is not None
    stored = plan.sizes.fragments / layers_of(plan.sizes)
    return round(stored * (SORTED_BYTES + PART_BYTES / 8))
