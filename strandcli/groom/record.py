"""Strands at rest, as solvers, children and drawing use them, and what is wrong with them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError


class Anchors(NamedTuple):
    """Points of a mesh, which move with its triangles. n: points."""

    triangles: NDArray[np.int32]
    """(n,)"""
    shares: NDArray[np.float64]
    """(n, 3) barycentric coordinates."""

    def of(self, order: Any) -> Anchors:
        """Return some of them, or all in another order."""
        return Anchors(self.triangles[order], self.shares[order])


class Bend(NamedTuple):
    """How strands turn toward the surface from root to tip. n: strands."""

    angle: float
    """In all, radians."""
    onset: float
    """Share of a strand before it begins, in [0, 1)."""
    inward: NDArray[np.float32]
    """(n, 3) unit vectors perpendicular to the strands' directions, to which they turn."""


class Widths(NamedTuple):
    """Widths of strands from a file, as factors of the material's. n: strands."""

    scale: NDArray[np.float32]
    """(n,) of the greatest width of each."""
    shares: NDArray[np.float32] | None = None
    """(n, points) of that at each point that is drawn, root to tip, in [0, 1]; None: 1."""

    def of(self, order: Any) -> Widths:
        """Return some of them, or all in another order."""
        return Widths(self.scale[order], None if self.shares is None else self.shares[order])


class Coat(NamedTuple):
    """Colours of strands. n: strands."""

    palette: NDArray[np.float32]
    """(k, 3) linear."""
    shades: int
    """Of each colour, among which the material's variation tells strands apart."""
    tones: NDArray[np.float32]
    """(n,) in [−1, 1], at which all shades of all colours stand evenly."""


@dataclass(frozen=True)
class Groom:
    """Strands at rest in the emitter's frame."""

    roots: NDArray[np.float32]
    """(strands, 3) metres."""
    directions: NDArray[np.float32]
    """(strands, 3) unit vectors."""
    lengths: NDArray[np.float32]
    """(strands,) metres from root to tip."""
    tones: NDArray[np.float32]
    """(strands,) in [−1, 1): deviation of each strand's colour from the mean."""

    curl: tuple[float, float] = (0.0, 0.0)
    """Angle between a strand and its axis, radians, and number of turns around the axis from root to tip."""
    places: NDArray[np.int32] | None = None
    """(strands,) number of each in the order of emission; None: they are in this order."""
    grown: NDArray[np.float64] | None = None
    """(strands, 3) metres: roots on the surface of tied strands, whose `roots` are at the tie; else None."""
    points: NDArray[np.float32] | None = None
    """(blocks, n + 1, 3 W) metres: the points of strands from a file, in the layout of `strandcli.groom.blocks`; else
    None."""
    widths: Widths | None = None
    """Of strands from a file that has any; None: all are as wide as the material's."""
    colours: NDArray[np.float32] | None = None
    """(k, 3) linear colours that stand evenly at tones −1 to 1, in place of the material's, or (A, k, 3) where they
    change from root to tip; else None."""
    shades: int = 1
    """Tones that each of the colours takes, from dark to pale."""
    bend: Bend | None = None
    """How strands that are not curled bend; None: they are straight."""
    phases: NDArray[np.float32] | None = None
    """(strands,) in [−1, 1): by which curled strands are turned around their axes; None: tones."""
    edges: NDArray[np.float64] | None = None
    """(strands, n − 1, 3) unit vectors, or zero: the edges of strands that are simulated with n particles in a shape of
    their own; else None."""
    anchors: Anchors | None = None
    """Where roots stand on the emitter's mesh; None: it is none."""
    film: Any = None
    """`strandcli.groom_file.film.Film` of strands of a file that move, of simulated ones with their rows (n,) in it;
    None: they do not."""

    def of(self, order: Any) -> Groom:
        """Return some of the strands, or all in another order; those that are not of a file."""
        return replace(
            self,
            roots=self.roots[order],
            directions=self.directions[order],
            lengths=self.lengths[order],
            tones=self.tones[order],
            places=None if self.places is None else self.places[order],
            grown=None if self.grown is None else self.grown[order],
            bend=None if self.bend is None else self.bend._replace(inward=self.bend.inward[order]),
            phases=None if self.phases is None else self.phases[order],
            anchors=None if self.anchors is None else self.anchors.of(order),
        )

    def edge(self, j: int, edges: int) -> NDArray[np.float64]:
        """Return (strands, 3) unit directions of edge j of ``edges``, root to tip, at its middle. Curled strands are
        helices, each turned around its axis by its phase."""
        if self.edges is not None:
            return self.edges[:, min(j, self.edges.shape[1] - 1)]  # solvers may ask for one more than there are
        angle, turns = self.curl
        axes = self.directions.astype(np.float64)
        if angle == 0 and self.bend is not None:
            done = max((j + 0.5) / edges - self.bend.onset, 0.0) / (1 - self.bend.onset)
            return np.asarray(np.cos(self.bend.angle * done) * axes + np.sin(self.bend.angle * done) * self.bend.inward)
        if angle == 0:
            return axes
        phases = self.tones if self.phases is None else self.phases
        first, second = frame(axes)
        around = 2 * np.pi * (turns * (j + 0.5) / edges + phases)[:, None]
        return np.asarray(np.cos(angle) * axes + np.sin(angle) * (np.cos(around) * first + np.sin(around) * second))

    @property
    def strands(self) -> int:
        """Number of strands."""
        return len(self.lengths)

    def emitted(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values of the strands, (strands, …), reordered from this groom's order to that of emission."""
        if self.places is None:
            return values
        out = np.empty_like(values)
        out[self.places] = values
        return out

    def placed(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values of the strands, (strands, …), reordered from the order of emission to this groom's."""
        return values if self.places is None else values[self.places]


def frame(axes: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two unit vectors orthogonal to each axis and to each other, (strands, 3), without a singularity (Duff et
    al. 2017, "Building an Orthonormal Basis, Revisited")."""
    x, y, z = axes.T
    sign = np.where(z >= 0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], 1), np.stack([b, sign + y * y * a, -y], 1)


UNIT = 1e-3
"""Tolerance of a direction's length."""


def check(groom: Groom) -> None:
    """Raise `UsageError` for the first strand whose root, direction or length is invalid, with the number of such
    strands."""
    with np.errstate(invalid="ignore", over="ignore"):
        sizes = np.linalg.norm(groom.directions.astype(np.float64), axis=1)
        found = (
            (~np.isfinite(groom.roots).all(1), "its root is not finite"),
            (~(np.abs(sizes - 1) <= UNIT), "its direction is no unit vector"),
            (~np.isfinite(groom.lengths), "its length is not finite"),
            (~(groom.lengths > 0), "its length is not positive"),
        )
    for bad, words in found:
        if bad.any():
            strand, count = int(np.argmax(bad)), int(bad.sum())
            more = f" ({count} such strands)" if count > 1 else ""
            raise UsageError(f"groom: strand {strand}: {words}{more}; leave it out, or mend it where it was made")
