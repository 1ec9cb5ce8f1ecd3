"""What a run takes, in seconds of one thread of the machine on which the stages were measured (docs/speed.md).

Each stage is taken to cost so much for each of its elements, of which `sizes` has the numbers. Another machine differs
by a factor, which `strandcli.calibration` measures and keeps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..draw.shadows.shadow_model import casts_map, model_of, needs_counts, shining
from ..scene.model import MeshShape
from .sizes import pairs_of, share_in_maps, side_of

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .make import Plan
    from .sizes import Sizes

NS = 1e-9
STEP, ROD_STEP, ON_MESH, INTERACTING = 5 * NS, 100 * NS, 140 * NS, 50 * NS
"""Of a particle in a step: by the source's rules, as a rod, and more beside a mesh or where strands push each other."""
TOUCHING, TOUCHED = 700 * NS, 8500 * NS
"""More where strands have contact: of a particle, to look for pairs; and of a pair, for each pair of a particle, since
the denser strands stand, the more rounds a step takes."""
FRAME, LOOKED_AT = 0.002, 20 * NS
"""Of a frame, whatever it holds; and of a particle, for the errors of the frame."""
CHILD, COMBED, CURVE, EVEN = 70 * NS, 60 * NS, 38 * NS, 12 * NS
"""Of a particle of a child, of one that is tied, and of a vertex; less where segments have as many pieces each."""
MAPPED, LAYER, MINMAX = 70 * NS, 2 * NS, 15 * NS
"""Of a vertex in a light: with an opacity map, more for each of its layers; with a min/max map."""
FOUND, BINNED, LINED = 38 * NS, 35 * NS, 14 * NS
"""Of a fragment of sorted strands and of a vertex of them, and of a vertex of lines in a z-buffer."""
COVERED = 0.45
"""Of a z-buffer's samples, those that show strands."""
LIT, SEEN, MOST_SEEN = 20 * NS, 110 * NS, 4.0
"""Of a vertex, for each light; and more by the root of the fragments that it has, up to so many: hidden ones are not
lit."""
LIGHTER = 0.25
"""Of that, what fibres without light from strand to strand take."""
SOFT, SHARP = 75 * NS, 25 * NS
"""Of a sample that shows a solid and a light, whose shadows have soft edges or not."""
SHOWN = 0.25
"""Of the samples, those that show solids, where none of them is a plane, which fills the picture."""
FILMED, WRITTEN, OCCLUDED = 32 * NS, 12 * NS, 60 * NS
"""Of a sample, of a pixel, and of a cell of the sky's grid and a direction."""
BEGIN, READ_MESH, EACH_STRAND, EACH_CHILD = 1.7, 0.6, 3e-6, 6e-6
"""Before the first frame: to start and to load kernels; to read meshes; and for each strand that may be drawn."""
WIDER = 0.8
"""Of a thread, what each further one adds."""


def frame_seconds(plan: Plan, scene: Scene) -> float:
    """Return the seconds of one thread that a frame takes; of panels those of all."""
    if scene.panels:
        parts = zip(plan.parts, scene.panels, strict=True)
        return sum(frame_seconds(part, panel) for part, panel in parts)
    return motion_seconds(plan, scene) * scene.time.substeps + drawing_seconds(plan, scene)


def motion_seconds(plan: Plan, scene: Scene) -> float:
    """Return the seconds of a step of the solver."""
    each = ROD_STEP if scene.solver == "rod" else STEP
    if scene.solver == "rod" and any(solid.kind == "mesh" for solid in scene.solids):
        each += ON_MESH
    if any(use.name == "interaction" for use in scene.rules):
        each += INTERACTING
    if not plan.steps:
        return 0.0
    pairs = pairs_of(scene, plan.strands)
    touching = TOUCHED * pairs**2 / plan.particles + (TOUCHING * plan.particles if pairs else 0.0)
    return plan.particles * each + touching


def drawing_seconds(plan: Plan, scene: Scene) -> float:
    """Return the seconds of drawing a frame, all exposures of it, and of writing it."""
    sizes = plan.sizes
    if sizes is None:
        return FRAME + plan.particles * LOOKED_AT
    exposures = scene.camera.samples if scene.camera.aperture > 0 or scene.camera.shutter > 0 else 1
    fixed = FRAME + plan.particles * LOOKED_AT + plan.pixels * WRITTEN
    if scene.children is not None or scene.emitter.followers is not None:
        fixed += sizes.made * sizes.points * CHILD
    if scene.emitter.tie is not None:
        fixed += sizes.strands * sizes.points * COMBED
    if scene.occluded and scene.ambient_occlusion is not None:
        fixed += scene.ambient_occlusion.cells * scene.ambient_occlusion.directions * OCCLUDED
    shadows = _shadow_seconds(sizes, scene)
    if scene.camera.shutter == 0:
        return fixed + shadows + exposures * _exposure_seconds(plan, scene, sizes)
    return fixed + exposures * (shadows + _exposure_seconds(plan, scene, sizes))


def _shadow_seconds(sizes: Sizes, scene: Scene) -> float:
    vertices, counts, total = sizes.segments + sizes.made, needs_counts(scene), 0.0
    for light in scene.lights:
        views = 1 if light.kind == "directional" else 6
        layers = model_of(light).layers(light.shadow)
        if casts_map(light, counts):
            share = share_in_maps(scene, sizes, side_of(scene, sizes, light))
            total += vertices * share * views * (MAPPED + layers * LAYER if layers else MINMAX)
    return total


def _exposure_seconds(plan: Plan, scene: Scene, sizes: Sizes) -> float:
    vertices = sizes.segments + sizes.made
    curve = CURVE if scene.curves.mode == "adaptive" else EVEN
    if scene.image.resolver == "zbuffer":
        shown, found = min(sizes.fragments, COVERED * plan.samples), vertices * LINED
    else:
        shown, found = sizes.fragments, sizes.fragments * FOUND + vertices * BINNED
    covered = shown / max(vertices, 1)
    each = LIT + SEEN * min(covered, MOST_SEEN) ** 0.5
    if scene.material.scatter != "dual":
        each *= LIGHTER
    drawn = found + plan.samples * FILMED + _solid_seconds(plan, scene)
    return vertices * (curve + len(shining(scene)) * each) + drawn


def _solid_seconds(plan: Plan, scene: Scene) -> float:
    """Return the seconds of shading solids."""
    seen = {solid.kind for solid in scene.solids if solid.visible}
    share = 1.0 if "plane" in seen else SHOWN if seen else 0.0
    return plan.samples * share * sum(SOFT if light.size > 0 else SHARP for light in shining(scene))


def scaled(seconds: float, threads: int) -> float:
    """Return what so many seconds of one thread take on several."""
    return seconds / (1 + WIDER * (threads - 1))


def run_seconds(plan: Plan, scene: Scene, factor: float = 1.0, threads: int = 1) -> tuple[float, float]:
    """Return the seconds a frame and in all that a run takes on a machine that needs ``factor`` times as long. Frames
    that are not drawn are simulated."""
    each = scaled(factor * frame_seconds(plan, scene), threads)
    panels = list(zip(plan.parts, scene.panels, strict=True)) if scene.panels else [(plan, scene)]
    steps = sum(
        motion_seconds(part, one) * max(0, part.steps - plan.frames * one.time.substeps) for part, one in panels
    )
    return each, factor * (_begin_seconds(panels) + scaled(steps, threads)) + plan.frames * each


def _begin_seconds(panels: list[tuple[Plan, Scene]]) -> float:
    meshes = any(
        isinstance(scene.emitter.shape, MeshShape) or any(solid.kind == "mesh" for solid in scene.solids)
        for _, scene in panels
    )
    strands = sum(
        (part.strands if part.sizes is None else part.sizes.strands)
        * (EACH_STRAND if scene.children is None else EACH_CHILD)
        for part, scene in panels
    )
    return BEGIN + (READ_MESH if meshes else 0.0) + strands
