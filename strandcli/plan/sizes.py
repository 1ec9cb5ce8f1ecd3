"""How large the parts of a frame are, as far as settings tell: lengths on the screen, vertices, fragments, shadow maps;
and what rods that meet take: pairs of segments for the rule contact, cells of the grid for the rule interaction.

Strands are taken to stand on their emitter's surface and to reach as far as they are long. A frame that is drawn has
counts of its own (report.json); these are what they come to before anything is read but meshes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ..draw.shadows.shadow_model import model_of
from ..scene.detail import mean_share, strands_needed
from ..scene.model import DiscShape, MeshShape, PlaneShape, SphereShape
from ..scene.model.emitter import TIED
from .decisions import samples_a_metre

if TYPE_CHECKING:
    from ..scene.model import Scene

SPREADS = (0.2, 0.5, 0.8, 1.1, 1.6)
"""Curvatures of segments over the mean: they differ along a strand, and by the angle at which it is seen."""
TURN = 2.0
"""Radians that strands without waves turn from root to tip."""
ACROSS = math.pi / 4
"""Mean length of lines of all directions on the screen, over their length."""
CROSSED, FOR_WIDTH = 1.3, 1.9
"""Samples that a line touches for each that it is long, and as many more for each that it is wide."""
HIDDEN = 0.45
"""Of fragments, those in front of what is opaque, where strands stand in locks."""
GATHERED = 0.5
"""What `squeezed` returns of long strands that are combed and hang."""
BULKY = 0.02
"""Radius of waves that hold strands apart, over their length."""
HELD, TOGETHER = 0.27, 0.6
"""Of a map's cells, those that hold strands; of these, as many where strands are tied."""
AROUND = 4
"""Cells that strands hold beyond the area that they are seen before, on both sides of it together."""
PRESSED = 0.95
"""Distance of strands that push each other once they hang, over that at which they begin to; locks are denser."""
UPRIGHT = 3**-0.5
"""Side of a cube over the diameter of the ball about it: a file's strands are looked at from one side of their box."""
HANGING = 0.55
"""How far strands that are combed or tied reach beyond what they grow on, over their length."""

GUESS = 3.0
"""Pairs of a particle of strands from a file."""
ALIKE = 0.45
"""Share of the boxes that meet of those that would if neighbours went in any direction."""
GRAVITY, FAR = 9.81, 1e6
"""m/s²: boxes hold what a segment falls in its first step, metres; they need not be larger than the second to meet."""
EACH = 180
"""Bytes of a cell: 101 of its own, and 32 in each box of a part of the strands that reaches it, 2.4 on average as
measured with `hair`."""
USUAL = 64_000_000
"""Bytes of a grid up to which other figures of `memory` hold it."""
LANES, MOST = 16, 4_000_000
"""Rows have so many cells, or a multiple of it; with more in all no run begins."""


class Sizes(NamedTuple):
    """Of the largest frame."""

    strands: int
    """That level of detail chooses from."""
    made: int
    """Of them, those that it draws and that are made."""
    points: int
    """Of each, before curves."""
    segments: float
    """Line pieces."""
    fragments: float
    """Of sorted strands, or samples that lines pass through."""
    scale: float
    """Samples a metre at the emitter."""
    radius: float
    """Of a ball about all strands, metres."""
    apart: float
    """Metres between neighbouring strands, half-way to their tips."""


def sizes_of(scene: Scene, strands: int, frames: Sequence[int]) -> Sizes:
    """Return the sizes of a scene of which so many strands are simulated."""
    times = [(frame - 1) / scene.time.fps for frame in sorted({*frames[:1], *frames[-1:]})] or [0.0]
    drawn, share = most_strands(scene, strands, times), 1.0
    if scene.detail is not None:
        share = max(mean_share(scene, time) for time in times)
        share = min(share * scene.drawn_strands / max(drawn, 1), 1.0)
    points = points_of(scene)
    scale = max(samples_a_metre(scene, time) for time in times)
    length = mean_length(scene)
    area, extent = surface(scene)
    emitter = scene.emitter
    radius = reach_of(scene)
    height = scene.image.size[1] * scene.image.supersample
    tall = 2 * radius * (1.0 if emitter.extent is None else UPRIGHT)
    share_seen = min(1.0, height / max(scale * tall, 1e-9))
    segments = drawn * share * (points - 1) * pieces_of(scene, scale * min(1.0, share_seen + 0.5), length, points)
    ahead = drawn * share * length * scale * ACROSS * share_seen
    width = scene.material.width * (1 - scene.material.drawn_taper / 2) * scale if scene.material.width > 0 else 1.0
    shown = HIDDEN if scene.children is not None and scene.children.clumps else 1.0
    if emitter.extent is None:
        apart = math.sqrt(max(area, 1e-12) * squeezed(scene, extent, length) / max(drawn * share, 1.0))
    else:
        from ..draw.geometry.spacing import spacing_of  # Numba, which scenes of no file do without
        from ..groom_file import from_scene

        groom = from_scene(scene).groom
        assert groom.points is not None
        there = emitter.strands if emitter.followers is None else emitter.followers.strands
        apart = spacing_of(groom.points, groom.strands) * math.sqrt(there / max(drawn * share, 1.0))
    if pressed := next((use.parameters.density for use in scene.rules if use.name == "interaction"), 0.0):
        apart = min(apart, PRESSED / math.sqrt(pressed))  # the weight of what hangs brings them as near
    made = round(drawn * share) if scene.children is not None else drawn
    return Sizes(drawn, made, points, segments, ahead * (CROSSED + FOR_WIDTH * width) * shown, scale, radius, apart)


def reach_of(scene: Scene) -> float:
    """Return the radius of a ball about all strands, metres."""
    emitter = scene.emitter
    if emitter.extent is not None:
        return emitter.extent.radius
    hangs = emitter.comb is not None or emitter.tie is not None or isinstance(emitter.shape, MeshShape)
    return surface(scene)[1] + (HANGING if hangs else 1.0) * mean_length(scene)


def most_strands(scene: Scene, strands: int, times: Sequence[float]) -> int:
    """Return the greatest number of strands that are drawn at some times."""
    if scene.emitter.followers is not None:
        return scene.emitter.followers.drawn
    if scene.children is None:
        return strands
    least = 0 if scene.detail is None else max((strands_needed(scene, time) for time in times), default=0)
    return least or scene.drawn_strands


def points_of(scene: Scene) -> int:
    """Return the number of particles of a drawn strand."""
    n, followers = scene.emitter.particles, scene.emitter.followers
    if followers is not None:
        return followers.points
    if scene.children is not None:
        n = (n - 1) * scene.children.steps(scene.emitter.segment) + 1
    return n if scene.emitter.tie is None else n + TIED


def mean_length(scene: Scene) -> float:
    """Return the mean length of drawn strands, metres."""
    length, children = scene.emitter.length, scene.children
    if children is None:
        return length
    short = children.undercoat * (1 - children.undercoat_length)
    return length * (1 - children.cut / 2) * (1 - short)


def surface(scene: Scene) -> tuple[float, float]:
    """Return the area that strands grow on, m², and the radius of a ball about it, metres."""
    shape, followers = scene.emitter.shape, scene.emitter.followers
    if followers is not None:
        return math.pi * followers.radius**2, followers.radius
    if isinstance(shape, PlaneShape):
        return shape.width * shape.depth, math.hypot(shape.width, shape.depth) / 2
    if isinstance(shape, DiscShape):
        return math.pi * shape.radius**2, shape.radius
    if isinstance(shape, MeshShape):
        from ..groom.on_mesh import seedbed

        bed = seedbed(shape)
        return float(bed.grown), math.sqrt(float(bed.grown) / math.pi)
    cap = math.radians(shape.cap)
    return 2 * math.pi * shape.radius**2 * (1 - math.cos(cap)), shape.radius * (math.sin(cap) if cap < 1.57 else 1.0)


def squeezed(scene: Scene, extent: float, length: float) -> float:
    """Return the cross section of all strands half-way to their tips, over the area that they grow on."""
    locks = scene.children.clumps if scene.children is not None else ()
    together = math.prod((1 - lock.strength / 2) ** 2 for lock in locks)
    if scene.emitter.tie is not None:
        return 0.3 * together
    emitter = scene.emitter
    if length > extent and _lies_smooth(scene, length):
        return GATHERED * together
    flat = isinstance(emitter.shape, PlaneShape | DiscShape | MeshShape) or emitter.comb is not None
    return together if flat or emitter.direction is not None else together * (1 + length / 2 / max(extent, 1e-9)) ** 2


def _lies_smooth(scene: Scene, length: float) -> bool:
    """Whether strands are combed and have no curls that hold them apart."""
    emitter, waves = scene.emitter, scene.children.waves if scene.children is not None else ()
    combed = emitter.comb is not None or (isinstance(emitter.shape, MeshShape) and emitter.shape.comb is not None)
    return combed and emitter.curl_turns == 0 and all(wave.radius < BULKY * length for wave in waves)


def pieces_of(scene: Scene, scale: float, length: float, points: int) -> float:
    """Return the mean number of pieces of a segment. A chord of a curve departs from it by κ h² / 8."""
    curves = scene.curves
    if curves.mode in ("off", "thinned"):
        return 1.0
    most = 2**curves.level
    if curves.mode == "fixed":
        return float(most)
    emitter = scene.emitter
    bends = [TURN / max(length, 1e-9)]
    if emitter.curl_turns > 0:
        bends.append(2 * math.pi * emitter.curl_turns / emitter.length * math.sin(math.radians(emitter.curl_angle)))
    for wave in scene.children.waves if scene.children is not None else ():
        bends.append(wave.radius * (2 * math.pi / wave.length) ** 2 * wave.share * (1 - wave.onset / 2))
    chord = length / max(points - 1, 1)
    off = math.hypot(*bends) * chord**2 / 8 * scale / curves.tolerance
    return sum(min(max(math.ceil(math.sqrt(spread * off)), 1), most) for spread in SPREADS) / len(SPREADS)


def map_rows(scene: Scene, sizes: Sizes, side: int, texel: float | None) -> tuple[int, float]:
    """Return the texels along a side of an opacity map, and how many of its cells of 2 × 2 hold strands."""
    wanted = texel or max(1.5 * sizes.apart, scene.material.width)
    found = min(max(2 * math.ceil(2 * sizes.radius / max(wanted, 1e-9) / 2), 4), side)
    if scene.emitter.extent is None:
        hidden = HELD * (1.0 if scene.emitter.tie is None else TOGETHER) * found**2 / 4
    else:  # a square of that area
        across = math.sqrt(scene.emitter.extent.area) / max(2 * sizes.radius, 1e-9) * found / 2
        hidden = min((across + AROUND) ** 2, found**2 / 4)
    return found, min(hidden, sizes.segments)


def share_in_maps(scene: Scene, sizes: Sizes, side: int) -> float:
    """Return the share of vertices that are projected into a light's map of so many texels a side: where all segments
    have as many pieces, few chords follow a curve to half a texel."""
    curves = scene.curves
    if curves.mode != "fixed":
        return 1.0
    texels = mean_length(scene) / max(sizes.points - 1, 1) * side / (2 * max(sizes.radius, 1e-9))
    needed, pieces = 1, 2**curves.level
    while needed < pieces and texels / (8 * needed * needed) > 0.5:
        needed *= 2
    return needed / pieces


def side_of(scene: Scene, sizes: Sizes, light: Any) -> int:
    """Return the texels along a side of a light's map."""
    model = model_of(light)
    side = int(model.side_of(light.shadow))
    return map_rows(scene, sizes, side, light.shadow.texel)[0] if model.layers(light.shadow) else side


def pairs_of(scene: Scene, strands: int) -> float:
    """Return how many pairs of segments of so many strands have boxes that meet in a step; 0 without the rule
    contact."""
    thickness = next((use.parameters.thickness for use in scene.rules if use.name == "contact"), 0.0)
    if thickness == 0.0 or scene.solver != "rod" or strands < 2:
        return 0.0
    emitter = scene.emitter
    particles = strands * emitter.particles
    if emitter.groom is not None:
        return GUESS * particles
    from ..simulate.rod.material import MARGIN, matter  # NumPy comes with it

    each = emitter.length / (emitter.particles - 1)
    reach = min((1 + MARGIN) * (thickness or 2 * matter(scene.rod)[1]), FAR)
    fall = min(GRAVITY / (scene.time.fps * scene.time.substeps) ** 2, FAR)
    box = (each + 2 * reach) ** 2 * (each + 2 * reach + 2 * fall)
    area, extent = surface(scene)
    if emitter.tie is not None:
        area = math.pi * emitter.tie.radius**2
    parts = isinstance(emitter.shape, SphereShape) and emitter.comb is None and emitter.direction is None
    spread = emitter.length / max(extent, 1e-9) if parts and emitter.tie is None else 0.0
    # of strands that part as they leave a ball, 1 / (1 + spread h)² on average over their height h
    pairs = ALIKE / 2 * strands * particles * box / (max(area, 1e-12) * each * (1 + spread))
    return min(pairs, particles * float(strands))


def grid_bytes(scene: Scene, strands: int) -> int:
    """Return the bytes of the grid of so many rods, 0 without the rule or for usual cells. Of strands from a file,
    which is not read for it, 0."""
    cell = next((use.parameters.cell for use in scene.rules if use.name == "interaction"), None)
    if cell is None or scene.solver != "rod" or strands < 1 or scene.emitter.groom is not None:
        return 0
    side = min(math.ceil(2 * reach_of(scene) / cell) + 2, 1e6)
    taken = EACH * int(min(-(-side // LANES) * LANES * side**2, MOST))
    return taken if taken >= USUAL else 0
