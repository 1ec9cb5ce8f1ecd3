"""Where strands come from."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass

from ..fields import Vector, boolean, choice, file, integer, items, names, number, optional, text, union, vector
from .placed import MeshShape, PoseKey, longest_side, placing, unit_scale, up_axis


@dataclass(frozen=True, slots=True, repr=False)
class SphereShape:
    """Roots spread evenly by area over a sphere about the emitter's origin, or over its cap about +y."""

    kind: str = choice("sphere", ("sphere",))
    radius: float = number(1.0, above=0, unit="m", doc="radius")
    cap: float = number(180.0, above=0, high=180, unit="deg", doc="polar angle from +y down to which roots reach")


@dataclass(frozen=True, slots=True, repr=False)
class DiscShape:
    """Roots spread evenly over a disc in the xz plane, facing +y."""

    kind: str = choice("disc", ("disc",))
    radius: float = number(1.0, above=0, unit="m", doc="radius")


@dataclass(frozen=True, slots=True, repr=False)
class PlaneShape:
    """Roots spread evenly over a rectangle in the xz plane, facing +y."""

    kind: str = choice("plane", ("plane",))
    width: float = number(2.0, above=0, unit="m", doc="extent along x")
    depth: float = number(2.0, above=0, unit="m", doc="extent along z")


TIED = 20
"""Points at which a strand that is tied lies, from its root on, before it is where it is bound."""


@dataclass(frozen=True, slots=True, repr=False)
class Tie:
    """Strands bound as a ponytail: from root to tie they lie on the surface and move with the emitter; from there they
    are simulated, with the emitter's length, particles and jitter."""

    position: Vector = vector((0.0, 1.0, 0.0), unit="m", doc="place of the tie: above the nearest point of the surface")
    radius: float = number(
        0.018, above=0, unit="m", doc="radius of the bundle; the thickness of combed hair follows from it"
    )
    lift: float = number(0.012, low=0, unit="m", doc="height of the tie above the surface")
    direction: Vector | None = vector(
        None, unit="1", nonzero=True, doc="direction of the bundle; absent: the surface normal"
    )
    spread: float = number(10.0, low=0, high=85, unit="deg", doc="angle at which strands leave the rim of the bundle")
    slack: float = number(0.0, low=0, unit="m", doc="greatest distance of loose strands from their combed path")
    wisps: float = number(0.0, low=0, high=1, doc="fraction of strands at the hairline that are too short for the tie")
    wisp_length: float = number(
        0.025,
        above=0,
        unit="m",
        doc="greatest length of wisps, and distance from the hairline over which they become rare (1/e)",
    )


@dataclass(frozen=True, slots=True, repr=False)
class GroomFile:
    """Strands of a file, in the emitter's frame. If there are rules, some are simulated as guides, and all follow
    them."""

    file: str = file(
        "strands",
        doc="strand file of a format that `convert` reads; of numbered files a pattern: strands.####.ply or "
        "strands.%04d.ply",
        numbered=True,
    )
    start: float | None = number(
        None, low=-1e6, high=1e9,
        doc="what frame 1 shows of moving strands: seconds, or the number of a numbered file; absent: the first",
    )  # fmt: skip
    up: str = up_axis(auto="as the file says, or a clear guess, else y")
    root: str = choice(
        "auto",
        ("auto", "first", "last"),
        doc="which point is the root. auto: the first, and with `fix` the last where that is clearly right",
    )
    fix: bool = boolean(
        False, doc="leave out strands that are not finite, have no length or are duplicates; false: they are refused"
    )
    scale: float | None = unit_scale(absent="as the file says, else 1")
    size: float | None = longest_side(box="the box about all strands")
    place: str = placing(where="they are", box="their box")
    colours: str = choice(
        "file",
        ("file", "none"),
        doc="file: the file's colours along each strand, where it has any; none: the material's",
    )
    strands: int | None = integer(
        None, low=1, high=100_000_000, doc="number of strands, chosen by the seed; absent: all"
    )
    guides: int = integer(
        2000, low=1, high=10_000_000,
        doc="strands that are simulated if there are rules, with emitter.particles each; the others follow them",
    )  # fmt: skip
    cover: float | None = number(
        None, above=0, high=1000,
        doc="without widths: choose one with which strands cover their silhouette so many times, at most 1/200 of "
        "the groom's size; absent: lines one pixel wide",
    )  # fmt: skip
    on: str = text(
        "",
        doc="name of a solid onto which roots are moved, and out of which strands are moved, as it is placed at "
        "frame 1; absent: none",
    )
    stride: int | None = integer(None, low=2, high=1_000_000, doc="points per strand, if the file has only vertices")
    array: str = text("", doc="array of the points, if an .npz file has several")
    object: tuple[str, ...] = names(doc="objects of the file that are used; empty: all")


HEADS = ("sphere", "capsule", "box", "plane", "mesh")
"""Kinds of solids that strands of a file can be put on."""
FILE_LEAVES = ("groom", "position", "rotation", "keys")
"""Settings of an emitter that hold where its strands are those of a file."""
GUIDED_LEAVES = ("particles",)
"""Further ones that hold where some of these are simulated."""


@dataclass(frozen=True, slots=True)
class Followers:
    """The strands of a file that follow simulated ones, as they are found when the file is read."""

    strands: int
    """That the file has."""
    drawn: int
    """Of them, those that some frame draws: level of detail leaves the rest out."""
    points: int
    """Of each, as it is drawn."""
    file_points: int
    """Of the longest in the file."""
    tolerance: float
    """Metres that the drawn strands may be off those of the file; 0: all points are drawn."""
    tolerance_px: float
    """The same on the screen where the camera is nearest."""
    deviation: float
    """Greatest distance of a point from its guide as it is simulated, metres."""
    deviation_share: float
    """The greatest, over the strand's length."""
    centre: Vector
    """Middle of the box about all roots, in the emitter's frame."""
    radius: float
    """Metres from there to the farthest root."""


@dataclass(frozen=True, slots=True)
class Extent:
    """What room the strands of a file take up, as it is found when the file is read."""

    radius: float
    """Of a ball about them all, metres."""
    area: float
    """Square metres that they are seen before, on average."""


LEAST_LENGTH = 1e-6
"""Of the mean length, that any strand has at the least, because one without length has no direction."""
LEAST_MAPPED = 0.02
"""Least factor by a mesh's map of lengths."""


@dataclass(frozen=True, slots=True, repr=False)
class Emitter:
    """Where strands grow, their number and length, and how the emitter moves (thesis §1)."""

    shape: SphereShape | DiscShape | PlaneShape | MeshShape = union(
        SphereShape(),
        {"sphere": SphereShape, "disc": DiscShape, "plane": PlaneShape, "mesh": MeshShape},
        doc="surface of the roots",
    )
    strands: int = integer(10_000, low=1, high=100_000_000, doc="simulated strands")
    particles: int = integer(10, low=2, high=100_000, doc="particles per strand, root included")
    length: float = number(1.0, above=0, unit="m", doc="mean strand length from root to tip")
    length_variation: float = number(
        0.0, low=0, high=1, doc="lengths are uniform in length * (1 - v) ... length * (1 + v)"
    )
    direction: Vector | None = vector(None, unit="1", nonzero=True, doc="growing direction; absent: the surface normal")
    comb: Vector | None = vector(
        None,
        unit="1",
        nonzero=True,
        doc="direction in which strands are combed along the surface; absent: they are not",
    )
    lift: float = number(30.0, low=0, high=90, unit="deg", doc="angle of combed strands to the surface")
    parting: float | None = number(
        None,
        unit="m",
        doc="x of a parting from the front to the middle, with strands combed away from it on both sides; absent: none",
    )
    tie: Tie | None = optional(Tie, doc="a ponytail: strands are combed to one place and hang from it; absent: none")
    groom: GroomFile | None = optional(
        GroomFile, doc="strands of a file, which only position, rotation and keys apply to; absent: strands are grown"
    )
    jitter: float = number(0.0, low=0, high=180, unit="deg", doc="cone within which each strand's direction is tilted")
    curl_angle: float = number(
        25.0, low=0, high=80, unit="deg", doc="angle of a curled strand to its axis; needs curl_turns"
    )
    curl_turns: float = number(0.0, low=0, high=1000, doc="turns of a helix from root to tip; 0: straight")
    bend: float = number(
        0.0, low=-360, high=360, unit="deg",
        doc="angle by which strands turn toward the surface from bend_onset to the tip; negative: away from it; "
        "not with curls or a tie",
    )  # fmt: skip
    bend_onset: float = number(0.0, low=0, high=0.95, doc="fraction of the strand before the bend")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="position, if there are no keys")
    rotation: Vector = vector(
        (0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z, if there are no keys"
    )
    keys: tuple[PoseKey, ...] = items(PoseKey, doc="motion; roots and directions turn with it")
    followers: Followers | None = None
    """What follows the simulated strands of a file; None where there is no file, or nothing of it is simulated."""
    moving: bool = False
    """Whether there is a file whose strands move, as it is found when the file is read."""
    extent: Extent | None = None
    """Of the strands of a file, all of them; None where there is no file."""

    @property
    def segment(self) -> float:
        """The longest distance between two particles of a strand, metres."""
        return self.length * (1 + self.length_variation) / (self.particles - 1)

    @property
    def shortest_segment(self) -> float:
        """A lower bound of the distances between two particles of grown strands, metres."""
        mapped = LEAST_MAPPED if isinstance(self.shape, MeshShape) and self.shape.length else 1.0
        return mapped * self.length * max(1 - self.length_variation, LEAST_LENGTH) / (self.particles - 1)
