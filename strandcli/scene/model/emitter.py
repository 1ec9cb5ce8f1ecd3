"""Where strands come from."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass

from ..fields import Vector, boolean, choice, file, integer, items, names, number, optional, text, union, vector
from . import placed_file
from .mesh_shape import MeshShape
from .pose import PoseKey


@dataclass(frozen=True, slots=True, repr=False)
class SphereShape:
    """Roots spread evenly by area over a sphere about the emitter's origin, or over its cap about +y."""

    kind: str = choice("sphere", ("sphere",))
    radius: float = number(1.0, above=0, unit="m", doc="radius")
    cap: float = number(180.0, above=0, high=180, unit="deg", doc="polar angle that the roots reach down to from +y")
    ragged: float = number(
        0.0, low=0, high=90, unit="deg", doc="how far a cap's rim wanders up and down and thins out; 0: a clean circle"
    )


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
    """Strands bound together, as a ponytail: each lies along the surface from its root to the tie, moves with the
    emitter as if it were a part of it, and hangs from there. The emitter's length, particles and jitter are those of
    what hangs.
    """

    position: Vector = vector((0.0, 1.0, 0.0), unit="m", doc="where; the tie is above the nearest point of the surface")
    radius: float = number(0.018, above=0, unit="m", doc="of the bundle, which tells how thick the hair lies elsewhere")
    lift: float = number(0.012, low=0, unit="m", doc="height of the tie above the surface")
    direction: Vector | None = vector(
        None, unit="1", nonzero=True, doc="of the bundle, away from the surface; absent: the surface normal"
    )
    spread: float = number(10.0, low=0, high=85, unit="deg", doc="angle to that at which strands leave the rim")
    slack: float = number(
        0.0, low=0, unit="m", doc="how far some strands bow off their way, up and aside; most do so much less"
    )
    wisps: float = number(
        0.0, low=0, high=1, doc="share of the strands at the rim that are too short for the tie; fewer farther inside"
    )
    wisp_length: float = number(
        0.025, above=0, unit="m", doc="length of the longest of these; so far inside they are 37 % (1/e) as frequent"
    )
    over: tuple[str, ...] = names(doc="names of spheres and capsules that it is combed over, as they stand at first")


@dataclass(frozen=True, slots=True, repr=False)
class GroomFile:
    """Strands of another program, from a file: all their points are drawn. They are in the emitter's frame, so that its
    position, rotation and keys carry them. Their number, points and lengths are those of the file. Where rules move
    strands, some of the file's are simulated as guides, and all follow these."""

    file: str = file(
        "strands",
        doc="file of strands, of a format that `convert` reads; of files that are numbered by the frame "
        "the name with # or %04d for the number, as strands.####.ply",
        numbered=True,
    )
    start: float | None = number(
        None, low=-1e6, high=1e9,
        doc="what frame 1 shows of strands that move: seconds in the file, of numbered files the number; absent: the "
        "first moment",
    )  # fmt: skip
    up: str = placed_file.up(auto="as the file says, or a clear guess, else y")
    root: str = choice(
        "auto",
        ("auto", "first", "last"),
        doc="which point of a strand is its root. auto: the first, but with `fix` where the other is clearly it",
    )
    fix: bool = boolean(
        False,
        doc="leave out strands that are not finite, have no length or repeat another. false: what cannot be drawn is "
        "refused",
    )
    scale: float | None = placed_file.scale(absent="as the file says, else 1")
    size: float | None = placed_file.size(box="the box about all strands")
    place: str = placed_file.place(where="they are", box="their box")
    colours: str = choice(
        "file",
        ("file", "none"),
        doc="file: each strand has its colours in the file, from root to tip, where there are any that differ, in "
        "place of the material's; none: the material's",
    )
    strands: int | None = integer(None, low=1, high=100_000_000, doc="so many of them, drawn by the seed; absent: all")
    guides: int = integer(
        2000, low=1, high=10_000_000,
        doc="strands that are simulated where rules move them, with emitter.particles each; the others follow",
    )  # fmt: skip
    cover: float | None = number(
        None, above=0, high=1000,
        doc="where material.width is 0 and the file has no widths: strands are so wide that they cover what they are "
        "seen before so many times, at most 1/200 of the longest side of their box; absent: lines one pixel wide",
    )  # fmt: skip
    on: str = text(
        "",
        doc="name of a solid, as it stands at first: roots off its surface are moved onto it, their strands with them, "
        "and strands inside are led out; absent: strands stay where they are",
    )
    stride: int | None = integer(None, low=2, high=1_000_000, doc="points a strand, where the file has vertices alone")
    array: str = text("", doc="array of the points, where an .npz file has several")
    object: tuple[str, ...] = names(doc="objects of the file whose strands are wanted; absent: all")


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
    kept: int
    """Of them, those that some frame draws: level of detail leaves the others out."""
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
    spacing: float
    """Metres between neighbouring strands; 0 of a single one."""
    area: float
    """Square metres that they are seen before, on average."""


LEAST_LENGTH = 1e-6
"""Of the mean length, that any strand has at the least, because one without length has no direction."""
LEAST_MAPPED = 0.02
"""Least factor by a mesh's map of lengths."""


@dataclass(frozen=True, slots=True, repr=False)
class Emitter:
    """Where strands grow, how many and how long, and how the whole of it moves (thesis §1)."""

    shape: SphereShape | DiscShape | PlaneShape | MeshShape = union(
        SphereShape(),
        {"sphere": SphereShape, "disc": DiscShape, "plane": PlaneShape, "mesh": MeshShape},
        doc="surface that bears the roots",
    )
    strands: int = integer(10_000, low=1, high=100_000_000, doc="number of strands")
    particles: int = integer(10, low=2, high=100_000, doc="particles a strand, root included")
    length: float = number(1.0, above=0, unit="m", doc="mean strand length from root to tip")
    length_variation: float = number(
        0.0,
        low=0,
        high=1,
        doc="lengths are even in length * (1 - v) ... length * (1 + v); at 1 some are almost nothing",
    )
    direction: Vector | None = vector(None, unit="1", nonzero=True, doc="growing direction; absent: the surface normal")
    comb: Vector | None = vector(
        None, unit="1", nonzero=True, doc="strands are combed this way along the surface; absent: they are not"
    )
    lift: float = number(30.0, low=0, high=90, unit="deg", doc="angle of combed strands to the surface")
    parting: float | None = number(
        None,
        unit="m",
        doc="x of a parting that ends at the middle: in front of that, strands to its left are combed the other way "
        "along x, and behind it none along x; absent: none",
    )
    tie: Tie | None = optional(
        Tie, doc="strands are combed to one place and hang from there; absent: they hang from their roots"
    )
    groom: GroomFile | None = optional(
        GroomFile, doc="strands are those of a file, beside which only position, rotation and keys hold; absent: grown"
    )
    jitter: float = number(0.0, low=0, high=180, unit="deg", doc="cone within which each strand's direction is tilted")
    curl_angle: float = number(
        25.0, low=0, high=80, unit="deg", doc="angle of a curled strand to its own axis; only with curl_turns"
    )
    curl_turns: float = number(0.0, low=0, high=1000, doc="turns of a helix from root to tip; 0: straight")
    bend: float = number(
        0.0, low=-360, high=360, unit="deg",
        doc="by which strands turn toward the surface between bend_onset and the tip; below 0: away from it; not of "
        "curled or tied ones",
    )  # fmt: skip
    bend_onset: float = number(0.0, low=0, high=0.95, doc="share of a strand that is straight before that")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="where it stands when it has no keys")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="how it stands when it has no keys")
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
