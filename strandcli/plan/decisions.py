"""Decisions on the stages of a run, simulation and drawing: what runs, what is left out, and why."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

from ..common.counted import counted
from ..common.registry import FIBRES, SHADOWS
from ..constants import FRAGMENT_BYTES, FRAGMENTS
from ..draw.shadows.shadow_model import casts_map, counts_strands, needs_counts, needs_shadow_maps, shining
from ..scene.detail import MOST_FRAMES, share_bounds, times_of
from ..scene.model import MeshShape
from ..scene.model.emitter import TIED
from ..scene.motion import camera_at, deforming_ground, emitter_pose
from ..scene.named_files import files_of
from ..scene.rule_type import OWN_OF
from ..simulate.rules import idle, registry

if TYPE_CHECKING:
    from ..scene.model import Followers, Scene


class Stage(NamedTuple):
    """A stage of a run, the reason why it is run or left out, and which of the two."""

    stage: str
    why: str
    runs: bool = True


def decided(stage: str, runs: object, why: str, why_not: str) -> Stage:
    """A stage that is run, or left out."""
    return Stage(stage, why if runs else why_not, bool(runs))


def left_out(stage: str, why: str) -> Stage:
    """A stage that is not run."""
    return Stage(stage, why, runs=False)


def motion_decisions(scene: Scene, strands: int) -> Iterator[Stage]:
    """Yield the decisions on the stages of simulation; strands: number of simulated ones."""
    emitter, preroll = scene.emitter, scene.time.preroll
    if strands < emitter.strands:
        hidden = f"{emitter.strands - strands} of {emitter.strands}"
        yield left_out("strands", f"{hidden} are too far to be drawn in any frame")
    listed = {use.name for use in scene.rules}
    for use in scene.rules:
        why = idle(use, scene)
        if use.name in OWN_OF.get(scene.solver, ()):
            why = "rod lengths are exact and rods bend by their material"
        yield decided(f"rule {use.name}", not why, "the preset lists it", why)
    for name in registry():
        if name not in listed:
            yield left_out(f"rule {name}", "the preset does not list it")
    if "emitter_motion" not in listed and (len(emitter.keys) > 1 or deforming_ground(scene) is not None):
        carried = "emitter keys" if emitter.keys else "deform under the roots"
        yield left_out(carried, "no rule emitter_motion carries the roots along")
    if _moving(scene):
        steps = f"{preroll:g} s, {counted(_preroll_steps(scene), 'step')} before frame 1"
        yield decided("pre-roll", preroll, steps, "its time is zero")


def solver_steps(scene: Scene, frames: Sequence[int]) -> int:
    """Return the number of solver steps up to the last of the frames, including the pre-roll."""
    if not _moving(scene):
        return 0
    return _preroll_steps(scene) + (max(frames, default=1) - 1) * scene.time.substeps


def _moving(scene: Scene) -> bool:
    return any(not idle(use, scene) for use in scene.rules)


def _preroll_steps(scene: Scene) -> int:
    return round(scene.time.preroll * scene.time.fps * scene.time.substeps)


def drawing_decisions(scene: Scene, strands: int, frames: Sequence[int]) -> Iterator[Stage]:
    """Yield the decisions on the stages of drawing some frames; strands: number of simulated ones."""
    yield from _groom(scene, strands)
    yield from _curves(scene)
    yield from _shadows(scene)
    yield from _fibre(scene)
    yield from _surround(scene)
    yield from _things(scene)
    yield from _detail(scene, frames)
    yield from _coverage(scene)
    yield from _camera(scene)


def _groom(scene: Scene, strands: int) -> Iterator[Stage]:
    emitter = scene.emitter
    if emitter.followers is not None:
        yield from _followers(emitter.followers, strands, emitter.particles)
    else:
        around = f"{counted(scene.drawn_strands, 'strand')} drawn about {strands:,}"
        yield decided("children", scene.children, around, "the strands that are simulated are drawn")
    if isinstance(emitter.shape, MeshShape) and emitter.groom is None:
        from ..groom.on_mesh import described

        yield Stage("surface", described(emitter.shape, scene.drawn_strands))
    why = f"{TIED} points a strand from its root to the tie, which are not simulated"
    yield decided("combed parts", emitter.tie, why, "strands are not tied")


def _followers(followers: Followers, guides: int, particles: int) -> Iterator[Stage]:
    off = f"within {followers.deviation:.3g} m or {100 * followers.deviation_share:.2g} % of the length of the file's"
    yield Stage("guides", f"{guides:,} of {followers.strands:,} strands, {particles} particles each, {off}")
    fewer = "all" if followers.drawn == followers.strands else f"{followers.drawn:,} that level of detail draws"
    yield Stage("followers", f"{fewer} of {followers.strands:,} strands follow up to 4 guides each")
    why = f"{followers.points} of {followers.file_points} a strand are within {followers.tolerance_px:g} px of it"
    thinned = followers.points != followers.file_points
    yield decided("fewer points", thinned, f"{why}, {followers.tolerance:.3g} m", "all points of the file are drawn")


def _curves(scene: Scene) -> Iterator[Stage]:
    curves = scene.curves
    pieces = counted(2**curves.level, "piece")
    if curves.mode in ("off", "thinned"):
        yield left_out("curves", "the preset draws straight segments")
    if curves.mode == "thinned":
        yield Stage("fewer points", f"those within {curves.tolerance:g} px of the segment between others are left out")
    elif curves.mode == "fixed":
        yield Stage("curves", f"each segment becomes {pieces}")
    else:
        yield Stage("curves", f"within {curves.tolerance:g} px, with at most {pieces} a segment")
        if not needs_shadow_maps(scene):
            yield left_out("curves off the screen", "no shadow map needs them")


def _shadows(scene: Scene) -> Iterator[Stage]:
    lit = shining(scene)
    dark = len(scene.lights) - len(lit)
    if dark:
        yield left_out("lights", f"{dark} of {len(scene.lights)} are dark")
    maps = sum(casts_map(light, needs_counts(scene)) for light in lit)
    none = "" if lit else "there is no light"
    cast = f"{maps} {'light casts' if maps == 1 else 'lights cast'} the strands' shadows"
    yield decided("shadow maps", maps, cast, none or "no light asks for one")
    for name in SHADOWS.names():
        lights = sum(light.shadow.model == name for light in lit)
        if (stage := SHADOWS[name].stage(lights)) is not None:
            yield decided(stage[0], lights, stage[1], none or "no light asks for them")


def _fibre(scene: Scene) -> Iterator[Stage]:
    material, lit = scene.material, shining(scene)
    says = getattr(FIBRES[material.model], "plan", lambda material: "highlights are on")
    dark = "material.specular is zero" if lit else "there is no light"
    shiny = material.specular > 0 and lit
    yield decided(f"{material.model} tables", shiny, says(material) if shiny else "", dark)
    dual = material.scatter == "dual"
    why_not = "no light has an opacity map to count strands by" if dual else "material.scatter is the diffuse term"
    between = "light goes from strand to strand under lights with opacity maps"
    yield decided("dual scattering", dual and any(map(counts_strands, lit)), between, why_not)


def _surround(scene: Scene) -> Iterator[Stage]:
    if scene.environment is not None:
        yield Stage("environment", "a picture lights strands and solids from all round")
    grid = scene.ambient_occlusion
    cells = "" if grid is None else f"about {grid.cells:,} cells, light from {grid.directions} directions"
    none = "the preset has none" if grid is None else "there is no light from everywhere"
    yield decided("ambient occlusion", scene.occluded, cells, none)


def _things(scene: Scene) -> Iterator[Stage]:
    material = scene.material
    varied = material.tip_colour is not None or material.colour_variation > 0 or material.grey > 0
    yield decided("colour variation", varied, "strands differ", "all strands have one colour")
    visible = sum(solid.visible for solid in scene.solids)
    yield decided("solids", visible, f"{visible} to draw, to hide strands and to cast shadows", "there are none to see")
    for place, solid in enumerate(scene.solids):
        if solid.kind == "mesh":
            from ..mesh_file.needs import described

            yield Stage(f"solids.{place}", described(solid))


def _detail(scene: Scene, frames: Sequence[int]) -> Iterator[Stage]:
    if scene.detail is None:
        yield left_out("level of detail", "the preset has none")
        return
    times = times_of(scene, frames)
    some = times[:: -(-len(times) // MOST_FRAMES) or 1] + times[-1:]
    least = min((share_bounds(scene, time)[0] for time in some), default=1.0)
    blind = scene.detail.near is None and scene.material.width == 0
    why_not = "lines have no width, and no near is given" if blind else "every frame is near"
    far = f"down to {least:.3g} of the strands where they are farthest"
    yield decided("level of detail", least < 1, far, why_not)


def _coverage(scene: Scene) -> Iterator[Stage]:
    sorts, samples = scene.image.resolver != "zbuffer", scene.image.supersample
    most = f"at most {FRAGMENTS:,} fragments at once, {FRAGMENTS * FRAGMENT_BYTES / 1e6:,.0f} MB"
    yield decided("coverage", sorts, f"all strands of a pixel by depth; {most}", "each sample shows the nearest strand")
    wide = "true widths" if sorts else "where a strand is wider than a pixel"
    yield decided("body", scene.material.width != 0, wide, "material.width is zero: lines are a pixel wide")
    yield decided("supersampling", samples > 1, f"{samples} x {samples} samples a pixel", "one sample a pixel")
    yield Stage("shading", "only vertices of segments that are seen")


def _camera(scene: Scene) -> Iterator[Stage]:
    camera, layers = scene.camera, scene.image.aovs
    times = f"{counted(camera.samples, 'picture')} a frame"
    yield decided("depth of field", camera.aperture != 0, times, "the camera is a pinhole")
    yield decided("motion blur", camera.shutter != 0, times, "the shutter is not open")
    none = "image.background is none, with or without horizon"
    yield decided("alpha", scene.image.has_alpha, none, "there is a background")
    yield decided("layers", layers, ", ".join(layers), "image.aovs is empty")


THIN = 0.7
"""Width of a root on the screen, in samples, below which the z-buffer's lines are visibly too wide."""


def warnings_of(scene: Scene, frames: Sequence[int]) -> Iterator[str]:
    """Yield warnings, a line each, for some frames."""
    yield from _lines_too_wide(scene, frames)
    pictures = [(key, path) for key, path, kind in files_of(scene) if kind == "picture"]
    if pictures:
        from ..files.picture_samples import is_transparent  # NumPy comes with it

        for key, path in pictures:
            if is_transparent(path):
                yield f"{key}: {path}: its alpha is ignored; save it without, over the colour that is meant"


def _lines_too_wide(scene: Scene, frames: Sequence[int]) -> Iterator[str]:
    width = scene.material.width
    if width == 0 or scene.image.resolver != "zbuffer" or scene.look == "source" or not frames:
        return
    seen = width * samples_a_metre(scene, (frames[0] - 1) / scene.time.fps)
    if seen < THIN:
        yield (
            f"strands {1000 * width:g} mm wide are {seen:.2g} pixels wide here, and image.resolver zbuffer draws hard "
            "lines of one pixel: add --quality default, or set image.resolver=sorted; look: source requires the lines"
        )


def samples_a_metre(scene: Scene, time: float) -> float:
    """Return the number of samples of a metre at the emitter on the screen, at a time."""
    camera = scene.camera
    view = camera_at(camera, time)
    samples = scene.image.size[1] * scene.image.supersample
    if camera.kind == "orthographic":
        return samples / view.height
    away = math.dist(view.position, emitter_pose(scene.emitter, time).translation)
    return samples / 2 / math.tan(math.radians(view.fov) / 2) / max(away, camera.near)


def labelled(parts: Iterable[tuple[str, Iterable[str]]]) -> list[str]:
    """The warnings of panels, each once, behind the labels of those that it is of; a single scene's label is ""."""
    labels: dict[str, list[str]] = {}
    for label, found in parts:
        for words in found:
            labels.setdefault(words, []).append(label)
    return [f"{', '.join(filter(None, names))}: {words}" if any(names) else words for words, names in labels.items()]
