"""What a scene needs, what is left out and why, and the memory that it takes. Imports neither numpy nor numba.

The decisions are the drivers' own: they leave a stage out by the same conditions (`needs_…`) that are told here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from .constants import BATCH_VERTICES, FRAGMENT_BYTES, FRAGMENTS, GRID_BYTES, POINTS_BYTES, W
from .draw.geometry.detail import needed, shares
from .errors import RefusedError
from .registry import FIBRES
from .scene.model import Scene
from .scene.model.emitter import TIED
from .simulate.rules import idle, registry

if TYPE_CHECKING:
    from collections.abc import Sequence

RESIDENT = 190_000_000
"""Bytes of the interpreter, its libraries and the compiled kernels."""


@dataclass(frozen=True)
class Stage:
    """A stage of the run and the reason why it is run or left out."""

    stage: str
    why: str


@dataclass
class Plan:
    """What would run for some frames of a scene."""

    used: list[Stage] = field(default_factory=list)
    left_out: list[Stage] = field(default_factory=list)
    strands: int = 0
    """Strands that are simulated: no more than any frame draws."""
    particles: int = 0
    steps: int = 0
    """Solver steps, those of the pre-roll and of frames that are not drawn included."""
    frames: int = 0
    segments_max: int = 0
    """Line pieces a frame at the most."""
    pixels: int = 0
    samples: int = 0
    memory_bytes: int = 0
    """Peak of the whole process, estimated."""


def make_plan(scene: Scene, frames: Sequence[int], draw: bool = True) -> Plan:
    """The plan for some frames (numbered from 1). Panels add up."""
    if scene.panels:
        parts = [make_plan(panel, frames, draw) for panel in scene.panels]
        plan = Plan(frames=len(frames))
        for panel, part in zip(scene.panels, parts, strict=True):
            for stages, more in ((plan.used, part.used), (plan.left_out, part.left_out)):
                stages += [Stage(f"{panel.label or 'panel'}: {one.stage}", one.why) for one in more]
            for name in ("strands", "particles", "steps", "segments_max", "pixels", "samples"):
                setattr(plan, name, getattr(plan, name) + getattr(part, name))
        plan.memory_bytes = RESIDENT + sum(part.memory_bytes - RESIDENT for part in parts)
        return plan
    plan = Plan(frames=len(frames))
    _motion(plan, scene, frames, draw)
    if draw:
        _drawing(plan, scene, frames)
    plan.memory_bytes = _memory(plan, scene, draw)
    return plan


def needed_strands(scene: Scene, frames: Sequence[int]) -> int:
    """Strands that any of the frames draws: a strand that level of detail leaves out of all of them is never made,
    unless it guides others."""
    if scene.children is not None:
        return scene.emitter.strands
    counts = (needed(scene, (frame - 1) / scene.time.fps) for frame in frames)
    return max(counts, default=scene.emitter.strands)


def require_memory(plan: Plan) -> None:
    """Raise `RefusedError` where the estimate exceeds the memory that is free."""
    free = available_memory()
    if free is not None and plan.memory_bytes > free:
        raise RefusedError(
            f"this run would take about {plan.memory_bytes / 1e9:.1f} GB and {free / 1e9:.1f} GB are free: "
            "use fewer --strands or --particles, or a smaller --size"
        )


def available_memory() -> int | None:
    """Free bytes, by the system and by the control group of this process; None where nobody tells."""
    found = []
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            found += [1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable")]
    except OSError:
        pass
    group = Path("/sys/fs/cgroup")
    try:
        most = (group / "memory.max").read_text(encoding="ascii").strip()
        if most != "max":
            found.append(int(most) - int((group / "memory.current").read_text(encoding="ascii")))
    except (OSError, ValueError):
        pass
    return min(found, default=None)


def _motion(plan: Plan, scene: Scene, frames: Sequence[int], draw: bool) -> None:
    emitter = scene.emitter
    plan.strands = needed_strands(scene, frames) if draw else emitter.strands
    plan.particles = plan.strands * emitter.particles
    if plan.strands < emitter.strands:
        hidden = f"{emitter.strands - plan.strands} of {emitter.strands}"
        plan.left_out.append(Stage("strands", f"{hidden} are too far to be drawn in any frame"))
    moving = [use for use in scene.rules if not idle(use, scene)]
    listed = {use.name for use in scene.rules}
    for use in scene.rules:
        why = idle(use, scene)
        if scene.solver == "rod" and use.name in ("elasticity", "stiffness"):
            why = "rods keep their lengths exactly and bend by their material"
        (plan.left_out if why else plan.used).append(Stage(f"rule {use.name}", why or "the preset lists it"))
    for name in registry():
        if name not in listed:
            plan.left_out.append(Stage(f"rule {name}", "the preset does not list it"))
    if "emitter_motion" not in listed and len(emitter.keys) > 1:
        plan.left_out.append(Stage("emitter keys", "no rule emitter_motion carries the roots along"))
    if moving:
        before = round(scene.time.preroll * scene.time.fps * scene.time.substeps)
        plan.steps = before + (max(frames, default=1) - 1) * scene.time.substeps
        if scene.time.preroll == 0:
            plan.left_out.append(Stage("pre-roll", "its time is zero"))
        else:
            plan.used.append(Stage("pre-roll", f"{scene.time.preroll:g} s, {before} steps before frame 1"))


def _drawing(plan: Plan, scene: Scene, frames: Sequence[int]) -> None:
    use, skip = plan.used.append, plan.left_out.append
    curves = scene.curves
    pieces = 1 if curves.mode == "off" else 2**curves.level
    if scene.children is None:
        skip(Stage("children", "the strands that are simulated are drawn"))
    else:
        use(Stage("children", f"{scene.drawn_strands} strands are drawn about {plan.strands}"))
    if scene.emitter.tie is None:
        skip(Stage("combed parts", "strands are not tied"))
    else:
        use(Stage("combed parts", f"{TIED} points a strand from its root to the tie, which are not simulated"))
    plan.segments_max = _drawn(plan, scene) * (drawn_particles(scene) - 1) * pieces
    width, height = scene.image.drawn
    plan.pixels = width * height
    plan.samples = plan.pixels * scene.image.supersample**2
    if curves.mode == "off":
        skip(Stage("curves", "the preset draws straight segments"))
    elif curves.mode == "fixed":
        use(Stage("curves", f"each segment becomes {pieces} pieces"))
    else:
        use(Stage("curves", f"within {curves.tolerance:g} px where {pieces} pieces a segment are enough, else so many"))
        if not needs_shadow_maps(scene):
            skip(Stage("curves off the screen", "no shadow map needs them"))
    lit = [light for light in scene.lights if light.intensity > 0 and any(light.colour)]
    if len(lit) < len(scene.lights):
        skip(Stage("lights", f"{len(scene.lights) - len(lit)} of {len(scene.lights)} are dark"))
    exact = sum(light.shadow.model == "traced" for light in lit)
    maps = sum(light.shadow.model not in ("off", "traced") for light in lit) + (exact if needs_counts(scene) else 0)
    if maps:
        use(Stage("shadow maps", f"{maps} {'light casts' if maps == 1 else 'lights cast'} the strands' shadows"))
    else:
        skip(Stage("shadow maps", "there is no light" if not lit else "no light asks for one"))
    if exact:
        use(Stage("exact shadows", f"every strand against all others in {exact} {'light' if exact == 1 else 'lights'}; "
                  f"lists of about {GRID_BYTES / 1e6:,.0f} MB a light at most"))  # fmt: skip
    else:
        skip(Stage("exact shadows", "there is no light" if not lit else "no light asks for them"))
    if scene.material.specular > 0 and lit:
        says = getattr(FIBRES[scene.material.model], "plan", lambda material: "highlights are on")
        use(Stage(f"{scene.material.model} tables", says(scene.material)))
    else:
        skip(Stage(f"{scene.material.model} tables", "there is no light" if not lit else "material.specular is zero"))
    material = scene.material
    varied = material.tip_colour is not None or material.colour_variation > 0 or material.grey > 0
    if material.scatter == "dual":
        if any(light.shadow.model in ("opacity", "traced") for light in lit):
            use(Stage("dual scattering", "light goes from strand to strand under lights with opacity maps"))
        else:
            skip(Stage("dual scattering", "no light has an opacity map to count strands by"))
    else:
        skip(Stage("dual scattering", "material.scatter is the diffuse stand-in"))
    if scene.environment is not None:
        use(Stage("environment", "a picture lights strands and solids from all round"))
    if scene.occluded and scene.ambient_occlusion is not None:
        grid = scene.ambient_occlusion
        use(Stage("ambient occlusion", f"about {grid.cells:,} cells, light from {grid.directions} directions"))
    else:
        none = scene.ambient_occlusion is None
        skip(Stage("ambient occlusion", "the preset has none" if none else "there is no light from everywhere"))
    (use if varied else skip)(Stage("colour variation", "strands differ" if varied else "all strands have one colour"))
    visible = [solid for solid in scene.solids if solid.visible]
    if visible:
        use(Stage("solids", f"{len(visible)} to draw, to hide strands and to cast shadows"))
    else:
        skip(Stage("solids", "there are none to see"))
    fractions = [shares(scene, (frame - 1) / scene.time.fps)[0] for frame in frames]
    if scene.detail is None:
        skip(Stage("level of detail", "the preset has none"))
    elif min(fractions, default=1.0) < 1:
        use(Stage("level of detail", f"down to {min(fractions):.3g} of the strands where they are farthest"))
    else:
        blind = scene.detail.near is None and scene.material.width == 0
        skip(Stage("level of detail", "lines have no width, and no near is given" if blind else "every frame is near"))
    resolver = scene.image.resolver
    held = f"at most {FRAGMENTS:,} fragments at once, {_fragment_bytes(scene) / 1e6:,.0f} MB"
    if resolver == "zbuffer":
        skip(Stage("coverage", "each sample shows the nearest strand"))
    else:
        use(Stage("coverage", f"all strands of a pixel by depth; {held}"))
    if scene.material.width == 0:
        skip(Stage("body", "material.width is zero: lines are a pixel wide"))
    else:
        use(Stage("body", "where a strand is wider than a pixel" if resolver == "zbuffer" else "true widths"))
    if scene.image.supersample > 1:
        use(Stage("supersampling", f"{scene.image.supersample} x {scene.image.supersample} samples a pixel"))
    else:
        skip(Stage("supersampling", "one sample a pixel"))
    use(Stage("shading", "only vertices of segments that are seen"))
    camera = scene.camera
    times = f"{camera.samples} pictures a frame"
    if camera.aperture > 0:
        use(Stage("depth of field", times))
    else:
        skip(Stage("depth of field", "the camera is a pinhole"))
    if camera.shutter > 0:
        use(Stage("motion blur", times))
    else:
        skip(Stage("motion blur", "the shutter is not open"))
    if scene.image.aovs:
        use(Stage("layers", ", ".join(scene.image.aovs)))
    else:
        skip(Stage("layers", "image.aovs is empty"))


def drawn_particles(scene: Scene) -> int:
    """Particles of a strand as it is drawn."""
    n = scene.emitter.particles
    if scene.children is not None:
        n = (n - 1) * scene.children.steps(scene.emitter.segment) + 1
    return n if scene.emitter.tie is None else n + TIED


def _drawn(plan: Plan, scene: Scene) -> int:
    """Strands that are drawn at the most."""
    return plan.strands if scene.children is None else scene.drawn_strands


def needs_shadow_maps(scene: Scene) -> bool:
    """Whether any light has a shadow map."""
    return any(light.shadow.model != "off" and light.intensity > 0 and any(light.colour) for light in scene.lights)


def needs_counts(scene: Scene) -> bool:
    """Whether lights with exact shadows have opacity maps beside them: for solids, and for what counts strands."""
    solid = any(solid.visible for solid in scene.solids)
    return solid or scene.material.scatter == "dual" or "shadow" in scene.image.aovs


def pictures_that_fit(scene: Scene, frames: Sequence[int]) -> int:
    """How many frames may be drawn at once: more than one may at most double what the run takes, and use up half of
    what is free."""
    plan = make_plan(scene, frames)
    free = available_memory()
    spare = plan.memory_bytes if free is None else min(plan.memory_bytes, free // 2)
    state = plan.strands * 12 * (scene.emitter.particles + 1)  # of which each has a copy
    return 1 + spare // (_picture_bytes(plan, scene) + state)


def _memory(plan: Plan, scene: Scene, draw: bool) -> int:
    n = scene.emitter.particles
    blocks = -(-plan.strands // W) * W
    # the state, the emitted groom, and the float64 work of one row while strands are emitted
    total = RESIDENT + blocks * (12 * (n + 3) + 4 + 32 + 160)
    return total + (_picture_bytes(plan, scene) if draw else plan.strands * n * 24)


def _picture_bytes(plan: Plan, scene: Scene) -> int:
    strands, n = _drawn(plan, scene), drawn_particles(scene)
    per_strand = plan.segments_max // max(strands, 1) + 1
    vertices = strands * per_strand
    traced = sum(light.shadow.model == "traced" and light.intensity > 0 for light in scene.lights)
    if scene.image.resolver == "zbuffer" and not traced:
        vertices = min(vertices, BATCH_VERTICES + per_strand * W)
    light = 12 if needs_shadow_maps(scene) else 0
    tables = getattr(FIBRES[scene.material.model], "memory", lambda material: 0)
    total = vertices * (37 + light + (4 if scene.material.width > 0 else 0)) * 9 // 8
    total += strands * (8 + 8 + 2 * (n - 1) + 4 + 8 + 32) + tables(scene.material)
    if scene.children is not None:  # the guides as finely, the strands, and what they follow
        levels, waves = len(scene.children.clumps), len(scene.children.waves)
        total += 12 * (n + 1) * (plan.strands + strands * 9 // 8) + strands * (200 + 8 * levels + 12 * waves)
    if scene.emitter.tie is not None:  # as they are made, in blocks, and joined to what hangs from the tie
        total += strands * 12 * (2 * (TIED + 1) + n)
    # of each light with exact shadows the lists, where they begin, and the strands as it sees them; some three cells a
    # piece is usual, and one the least
    total += traced * (max(min(120 * vertices, GRID_BYTES), 40 * vertices) + 16 * 2048**2 + vertices * (12 + 64 + 4))
    if traced and scene.material.rounded and scene.material.width > 0:  # light and shadow across strands
        marked = scene.image.resolver != "zbuffer"  # which of their places are seen
        total += vertices * (4 + 204 * (1 + traced) + 128 * (traced + marked))
    if scene.occluded and scene.ambient_occlusion is not None:
        total += scene.ambient_occlusion.cells * (44 + scene.ambient_occlusion.directions)
    for one in scene.lights:
        if needs_shadow_maps(scene) and one.shadow.model != "off":
            if one.shadow.model == "traced" and not needs_counts(scene):
                continue
            # of a cell's numbers a quarter, where strands are: no box takes more than 1 / √3 of what the ball about it
            # does of a map
            cell = 4 * (2 + 5 * (one.shadow.layers + 1)) / 4 * (0.6 if one.kind == "directional" else 1)
            texel = 8 if one.shadow.model == "minmax" else 4 + cell
            total += int(texel * one.shadow.side**2) * (1 if one.kind == "directional" else 6)
    if scene.image.resolver != "zbuffer":  # each pixel has a list and what solids hide; vertices are marked twice
        total += _fragment_bytes(scene) + plan.samples * 12 * 9 // 8 + vertices
    if scene.image.haze is not None:  # the picture before solids are lit
        total += plan.samples * 12
    if scene.camera.shutter > 0:  # the frame before, and the moment between
        total += 2 * plan.strands * 12 * (scene.emitter.particles + 1)
    if scene.camera.aperture > 0 or scene.camera.shutter > 0:
        total += plan.samples * 12
    if scene.image.aovs:
        total += plan.pixels * 60 * 3  # three more pictures may wait to be written
    return total + plan.samples * 32 * 9 // 8 + plan.pixels * 3 * 8


def _fragment_bytes(scene: Scene) -> int:
    """Of sorted fragments, at most."""
    exact = any(light.shadow.model == "traced" for light in scene.lights) and scene.image.resolver == "sorted"
    return FRAGMENTS * (FRAGMENT_BYTES + (2 * POINTS_BYTES if exact else 0))
