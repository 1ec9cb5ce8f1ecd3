"""Estimates of the peak memory of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..constants import BATCH_VERTICES, FRAGMENT_BYTES, FRAGMENTS, POINTS_BYTES, W
from ..draw.shadows.needs import needs_counts, needs_shadow_maps
from ..draw.shadows.shadow_model import casts_map, model_of, shades_vertices
from ..registry import FIBRES
from ..scene.model.emitter import TIED

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .make import Plan

RESIDENT = 190_000_000
"""Bytes of the interpreter, its libraries and the compiled kernels."""


def drawn_particles(scene: Scene) -> int:
    """Return the number of particles of a drawn strand."""
    n, followers = scene.emitter.particles, scene.emitter.followers
    if followers is not None:
        return followers.points
    if scene.children is not None:
        n = (n - 1) * scene.children.steps(scene.emitter.segment) + 1
    return n if scene.emitter.tie is None else n + TIED


def drawn_strands(plan: Plan, scene: Scene) -> int:
    """Return the greatest number of drawn strands."""
    if scene.emitter.followers is not None:
        return scene.emitter.followers.kept
    return plan.strands if scene.children is None else scene.drawn_strands


def memory_of(plan: Plan, scene: Scene, draw: bool) -> int:
    """Return the peak bytes of the process."""
    n = scene.emitter.particles
    blocks = -(-plan.strands // W) * W
    # the state, the emitted groom, and the float64 work of one row while strands are emitted
    total = RESIDENT + blocks * (12 * (n + 3) + 4 + 32 + 160) + _mesh_bytes(scene)
    return total + (picture_bytes(plan, scene) if draw else plan.strands * n * 24)


def _mesh_bytes(scene: Scene) -> int:
    """Bytes of solids that are meshes: triangles, trees and grids of distances."""
    meshes = [solid for solid in scene.solids if solid.kind == "mesh"]
    if not meshes:
        return 0
    from ..mesh_file.needs import whole_bytes

    return sum(whole_bytes(solid) for solid in meshes)


def picture_bytes(plan: Plan, scene: Scene) -> int:
    """Return the greatest number of bytes for drawing one frame."""
    strands, n = drawn_strands(plan, scene), drawn_particles(scene)
    per_strand = plan.segments_max // max(strands, 1) + 1
    vertices = strands * per_strand
    traced = sum(shades_vertices(light) for light in scene.lights)
    if scene.image.resolver == "zbuffer" and not traced:
        vertices = min(vertices, BATCH_VERTICES + per_strand * W)
    light = 12 if needs_shadow_maps(scene) else 0
    total = vertices * (37 + light + (4 if scene.material.width > 0 else 0)) * 9 // 8
    total += strands * (8 + 8 + 2 * (n - 1) + 4 + 8 + 32)
    tables = getattr(FIBRES[scene.material.model], "memory", lambda material: 0)
    total += tables(scene.material)
    total += _groom_bytes(plan, scene) + _traced_bytes(scene, vertices, traced) + _light_bytes(scene)
    return total + _film_bytes(plan, scene, vertices)


def _groom_bytes(plan: Plan, scene: Scene) -> int:
    """Return the bytes of children and of tied strands."""
    strands, n = drawn_strands(plan, scene), drawn_particles(scene)
    total = 0
    if scene.children is not None:  # the guides as finely, the strands, and what they follow
        levels, waves = len(scene.children.clumps), len(scene.children.waves)
        total += 12 * (n + 1) * (plan.strands + strands * 9 // 8) + strands * (200 + 8 * levels + 12 * waves)
    followers = scene.emitter.followers
    if followers is not None:  # the file, as it is read and packed; at rest, with shares; as they are placed; a table
        total += followers.strands * (24 * (followers.file_points + 1) + 100)
        total += strands * (16 * n + 12 * n * 9 // 8 + 100) + plan.strands * 200 * scene.emitter.particles
    if scene.emitter.tie is not None:  # as they are made, in blocks, and joined to what hangs from the tie
        total += strands * 12 * (2 * (TIED + 1) + n)
    return total


def _traced_bytes(scene: Scene, vertices: int, traced: int) -> int:
    """Return the bytes of exact shadows; traced: number of lights with them."""
    total = sum(model_of(light).vertex_bytes(vertices) for light in scene.lights if shades_vertices(light))
    if traced and scene.material.rounded and scene.material.width > 0:  # light and shadow across strands
        marked = scene.image.resolver != "zbuffer"  # which of their positions are visible
        total += vertices * (4 + 204 * (1 + traced) + 128 * (traced + marked))
    return total


def _light_bytes(scene: Scene) -> int:
    """Return the bytes of ambient occlusion and shadow maps."""
    total = 0
    if scene.occluded and scene.ambient_occlusion is not None:
        total += scene.ambient_occlusion.cells * (44 + scene.ambient_occlusion.directions)
    counts = needs_counts(scene)
    for one in scene.lights:
        if casts_map(one, counts):
            total += model_of(one).map_bytes(one.shadow, one.kind == "directional")
    return total


def _film_bytes(plan: Plan, scene: Scene, vertices: int) -> int:
    """Return the bytes of fragments, samples and pixels."""
    total = 0
    if scene.image.resolver != "zbuffer":  # each pixel has a list and the solids' depth; vertices are marked twice
        total += fragment_bytes(scene) + plan.samples * 12 * 9 // 8 + vertices
    if scene.image.haze is not None:  # the picture before solids are lit
        total += plan.samples * 12
    if scene.camera.shutter > 0:  # the frame before, and the moment between
        total += 2 * plan.strands * 12 * (scene.emitter.particles + 1)
    if scene.camera.aperture > 0 or scene.camera.shutter > 0:
        total += plan.samples * 12
    if scene.image.aovs:
        total += plan.pixels * 60 * 3  # three more pictures may wait to be written
    return total + plan.samples * 32 * 9 // 8 + plan.pixels * 3 * 8


def fragment_bytes(scene: Scene) -> int:
    """Return the greatest number of bytes of sorted fragments in memory at once."""
    exact = any(shades_vertices(light) for light in scene.lights) and scene.image.resolver == "sorted"
    return FRAGMENTS * (FRAGMENT_BYTES + (2 * POINTS_BYTES if exact else 0))
