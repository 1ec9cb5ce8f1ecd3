"""A scene with what it takes from its file of strands: how many, how long, how wide, and where the camera stands; what
it simulates of them, and what follows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError, about
from ..exchange.files import USUAL
from ..exchange.kernels.along import simplify
from ..exchange.strands import even_offsets
from ..files.inputs import cached
from ..groom.blocks import spatial_order
from ..groom.followers import Following
from ..groom.record import Groom, Widths
from ..scene.detail import most_needed
from ..scene.model import Extent, Followers
from ..scene.motion import camera_at, emitter_pose
from .guides import BATCH, chained, chosen, features_of, long_enough, parents_of, picked_points, ranks_of
from .measure import fitted, some_of, width_for
from .on_solid import Head, head_of
from .read import FromFile, from_file, from_scene

if TYPE_CHECKING:
    from ..exchange.files import Moments
    from ..scene.model import GroomFile, Scene
    from ..scene.model.scene import Time

DENSE = 64
"""Points of a strand from which on it is as smooth as it is meant: adaptive curves would find one piece a segment."""
LOOKED_AT = 2000
"""Points, evenly chosen, of which the one nearest to the camera tells how fine strands have to be."""
UNEVEN = 0.01
"""Share of a strand's greatest width by which it may be wider or narrower where points are left out."""
TIMES = 240
"""Frames at most, evenly chosen, at which it is asked for."""


@dataclass(frozen=True, eq=False)
class Guided:
    """Strands of a file that are simulated, and those that follow."""

    guides: Groom
    following: Following
    deviation: float
    """Greatest distance of a point from its guide as it is simulated, metres."""
    deviation_share: float
    """The greatest, over the strand's length."""


def guided(scene: Scene) -> Guided:
    """What a scene simulates of its file, and what follows; the scene has been completed. The last one is cached."""
    given, followers = scene.emitter.groom, scene.emitter.followers
    assert given is not None
    assert followers is not None
    width = scene.material.width
    key = (scene.seed, scene.emitter.particles, followers.tolerance, followers.drawn, width)
    with about("strands", given.file):
        return _guided(replace(given, cover=None), *key, head_of(scene))


def with_followers(scene: Scene) -> Scene:
    """The scene with its `followers`, which its camera, its material and its level of detail decide on too."""
    emitter, given = scene.emitter, scene.emitter.groom
    assert given is not None
    found = from_scene(scene)
    roots = found.groom.roots.astype(np.float64)
    low, high = roots.min(axis=0), roots.max(axis=0)
    middle = 0.5 * (low + high)
    thinned = scene.curves.mode in ("adaptive", "thinned") and found.points > DENSE
    pixels = scene.curves.tolerance if thinned else 0.0
    metres = pixels * metres_a_pixel(scene, found)
    strands = found.groom.strands
    moving = emitter.moving and any(use.name == "emitter_motion" for use in scene.rules)
    if moving and scene.solver == "rod" and scene.rod.end == "pinned":
        raise UsageError(f"{given.file}: moves; tips cannot be pinned where roots move so; use rod.end: free")
    first = Followers(
        strands, strands, found.points, found.points, metres, pixels, 0.0, 0.0, (middle[0], middle[1], middle[2]),
        float(np.sqrt(((roots - middle) ** 2).sum(1).max())),
    )  # fmt: skip
    scene = replace(scene, emitter=replace(emitter, strands=min(given.guides, strands), followers=first))
    frames = range(1, 2 if scene.detail is None else 1 + scene.time.frames)
    drawn = most_needed(scene, frames)
    scene = replace(scene, emitter=replace(scene.emitter, followers=replace(first, drawn=drawn)))
    made = guided(scene)
    known = replace(
        first, drawn=drawn, points=made.following.points.shape[1], deviation=made.deviation,
        deviation_share=made.deviation_share,
    )  # fmt: skip
    return replace(scene, emitter=replace(scene.emitter, strands=made.guides.strands, followers=known))


def metres_a_pixel(scene: Scene, found: FromFile) -> float:
    """How long what is a pixel on the screen is where the camera is nearest to strands, over all frames."""
    camera, carried = scene.camera, any(use.name == "emitter_motion" for use in scene.rules)
    samples = scene.image.size[1] * scene.image.supersample
    points = found.seen.points[:: max(len(found.seen.points) // LOOKED_AT, 1)].astype(np.float64)
    still = not camera.keys and not (carried and scene.emitter.keys)
    frames = [0] if still else np.unique(np.linspace(0, scene.time.frames - 1, TIMES).astype(int)).tolist()
    least = math.inf
    for frame in frames:
        time = frame / scene.time.fps
        view, pose = camera_at(camera, time), emitter_pose(scene.emitter, time if carried else 0.0)
        if camera.kind == "orthographic":
            least = min(least, view.height / samples)
            continue
        eye = (np.array(view.position) - pose.translation) @ np.array(pose.rotation)
        away = max(float(np.linalg.norm(points - eye, axis=1).min()), camera.near)
        least = min(least, 2 * math.tan(math.radians(view.fov) / 2) * away / samples)
    return least


@cached(1)
def _guided(
    given: GroomFile, seed: int, particles: int, tolerance: float, drawn: int, width: float, head: Head | None
) -> Guided:  # fmt: skip
    groom = from_file(given, seed, head).groom
    features = features_of(groom)
    order = spatial_order(features)
    fit = long_enough(groom.lengths, particles)
    if not fit.any():
        raise UsageError(
            f"{given.file}: {particles:,} particles on strands of {float(groom.lengths.max()):.3g} m are too close for "
            "single precision; take fewer emitter.particles, or a greater emitter.groom.size"
        )
    own = chosen(features, order, given.guides, fit)
    own = own[spatial_order(groom.roots[own])]
    guides, deviation = chained(groom, own, particles)
    ranks = ranks_of(order, seed)
    some = np.flatnonzero(ranks < drawn)
    assert groom.places is not None
    parents, weights = parents_of(features[some], features[own])
    whole = groom.lengths[some].astype(np.float64)[:, None]
    reaches = np.minimum(whole / groom.lengths[own].astype(np.float64)[parents], 1.0).astype(np.float32)
    points, widths = _drawn(groom, some, tolerance, width)
    if groom.film is not None:
        guides = replace(guides, film=(groom.film, groom.places[own]))
    strands = Groom(
        groom.roots[some], groom.directions[some], groom.lengths[some], groom.tones[some], places=groom.places[some],
        widths=widths, colours=groom.colours, anchors=None if groom.anchors is None else groom.anchors.of(some),
        film=None if groom.film is None else (groom.film, groom.places[some]),
    )  # fmt: skip
    following = Following(strands, points, ranks[some], parents, weights, reaches, guides)
    share = deviation / groom.lengths[own]
    return Guided(guides, following, float(deviation.max()), float(share.max()))


def _drawn(
    groom: Groom, some: NDArray[np.int64], tolerance: float, width: float
) -> tuple[NDArray[np.float32], Widths | None]:
    """(k, m, 4) as many points of the strands ``some`` (k,) as have the rest within a tolerance in metres, and how
    far along its strand each is; and widths at these. ``width``: metres of a strand whose factor is 1."""
    assert groom.points is not None
    n = groom.points.shape[1] - 1
    widths = None if groom.widths is None else groom.widths.of(some)
    shares = None if widths is None else widths.shares
    keep = np.ones((len(some), n), np.bool_)
    if tolerance > 0:
        keep[:] = False
        for begin in range(0, len(some), BATCH):
            part = slice(begin, begin + BATCH)
            points = picked_points(groom, some[part])
            wide = None
            if widths is not None and shares is not None:
                greatest = np.maximum(width * widths.scale[part, None], 2 * tolerance / UNEVEN).astype(np.float32)
                wide = (shares[part] * greatest).reshape(-1)
            marked = keep[part].reshape(-1)
            first = even_offsets(len(points), n)
            simplify(first, points.reshape(-1, 3), wide, tolerance, marked, np.empty(len(points)))
    counts = keep.sum(axis=1)
    out = np.empty((len(some), int(counts.max()), 4), np.float32)
    fewer = None if shares is None else np.empty(out.shape[:2], np.float32)
    for begin in range(0, len(some), BATCH):
        part = slice(begin, begin + BATCH)
        points = picked_points(groom, some[part])
        rows = _evenly(keep[part], counts[part], out.shape[1])
        out[part, :, :3] = np.take_along_axis(points, rows[:, :, None], axis=1)
        out[part, :, 3] = np.take_along_axis(_shares(points), rows, axis=1)
        if fewer is not None and shares is not None:
            fewer[part] = np.take_along_axis(shares[part], rows, axis=1)
    return out, None if widths is None else widths._replace(shares=fewer)


def _evenly(keep: NDArray[np.bool_], counts: NDArray[np.int64], wanted: int) -> NDArray[np.int64]:
    """(S, wanted) the points to draw of strands (S, n): those that ``keep`` (S, n) marks, so many each (S,), and of the
    rest as many as are wanting, evenly chosen."""
    rest, wanting = (keep.shape[1] - counts)[:, None], (wanted - counts)[:, None]
    seen = np.cumsum(~keep, axis=1)
    more = seen * wanting // np.maximum(rest, 1) > (seen - 1) * wanting // np.maximum(rest, 1)
    return np.nonzero(keep | more)[1].reshape(-1, wanted)


def _shares(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """(S, n) how far along its strand each of points (S, n, 3) is, of its length; of one without length by number."""
    x, y, z = np.diff(points.astype(np.float64), axis=1).transpose(2, 0, 1)
    along = np.zeros(points.shape[:2])
    np.cumsum(np.sqrt(x * x + y * y + z * z), axis=1, out=along[:, 1:])
    whole, last = along[:, -1:], points.shape[1] - 1
    evenly = np.broadcast_to(np.arange(last + 1) / last, along.shape)
    return np.minimum(np.divide(along, whole, out=evenly.copy(), where=whole > 0), 1).astype(np.float32)


MOST_FRAMES = 1_000_000
SHARE = 0.4
"""Of the tolerance of curves, how far a point may be off that a dense strand is drawn without. A tenth of a pixel, of a
quarter, changes a picture of 100,000 strands by .6 of 255 (root mean square), twice as much of 20,000."""


def completed(scene: Scene) -> Scene:
    """The scene, each of its panels too, with numbers of its file in place of its defaults; the same where that has
    been done or there is no file. Raises `UsageError` for a file that cannot be
    drawn."""
    panels = tuple(completed(panel) for panel in scene.panels)
    if panels != scene.panels:
        scene = replace(scene, panels=panels, time=max((panel.time for panel in panels), key=lambda one: one.frames))
    given = scene.emitter.groom
    if given is None or scene.panels or scene.emitter.followers is not None:
        return scene
    found = from_scene(scene)
    mean = found.seen.length / found.strands
    scene = replace(scene, time=_clock(scene.time, found.moments, given.start))
    scene = replace(
        scene,
        emitter=replace(
            scene.emitter, strands=found.strands, length=mean, moving=found.moments is not None,
            extent=Extent(found.seen.radius, found.seen.area),
        ),
    )  # fmt: skip
    if not scene.guided:
        scene = replace(scene, emitter=replace(scene.emitter, particles=found.points), detail=None)
    if scene.material.width == 0:
        width = found.width
        if width is None and given.cover is not None:
            width = width_for(found.seen, given.cover)
        if width is not None:
            scene = replace(scene, material=replace(scene.material, width=width))
    if found.width is not None and scene.material.taper is None:
        scene = replace(scene, material=replace(scene.material, taper=0.0))
    if found.colour is not None:
        own = replace(scene.material, colour=found.colour, pigment="rgb", eumelanin=None, pheomelanin=None)
        scene = replace(scene, material=replace(own, tip_colour=None, grey=0.0))
    if scene.camera.fit is not None:
        later = map(some_of, found.groom.film.later()) if found.groom.film is not None else ()
        scene = replace(scene, camera=fitted(scene, np.concatenate([found.seen.points, *later])))
    if scene.guided:
        scene = with_followers(scene)
    if scene.curves.mode == "adaptive" and found.points > DENSE:
        mode, tolerance = ("off", 1.0) if scene.guided else ("thinned", SHARE)
        scene = replace(scene, curves=replace(scene.curves, mode=mode, tolerance=tolerance * scene.curves.tolerance))
    return scene


def _clock(time: Time, moments: Moments | None, start: float | None) -> Time:
    """A scene's clock, with what the file says where it has 0."""
    fps = time.fps or (moments.rate if moments is not None else USUAL)
    frames = time.frames or (min(moments.frames(fps, start), MOST_FRAMES) if moments is not None else 1)
    return replace(time, fps=fps, frames=frames)
