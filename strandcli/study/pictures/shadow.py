"""Shadow: models of the brightest light's shadow against rays that meet strands as cylinders.

What is compared is the share of light that reaches the points the picture shows, as the picture has it: the light on
matt white strands with the shadow, over that without. There are two questions. `transmittance` asks for the strand's
own light, about a vertex to the two next to it; a map, which blurs the shadows of single strands, has no such answer to
give. `around` asks for the mean over a bundle of rays, wider than the strands are apart, as pictures of hair
much thinner than a pixel show it; exact shadows are no answer to that.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.curves import Polylines, flatten
from ...draw.scratch import Scratch
from ...draw.shadow import Thickness
from ...errors import UsageError
from ...groom.emit import PLASTIC
from ...scene.model import DirectionalLight, Light, Scene
from ..axes import Axis, Request
from ..kernels import cylinders
from ..points import Knobs
from .experiment import Pictures
from .subject import Picture, changed, knows

PROBES = 400
RAYS = 256
BUNDLE = 1.5
"""Radius of a probe's bundle of rays, in distances between strands."""
ALONG = 16
"""Rays from a probe's strand on each side of it."""
BEYOND = 1e9
"""Metres: a bias behind which nothing is, for the light without a map's shade."""
FINEST = 4096
"""Texels along a side that a map may have where the side of a texel is given."""


class ShadowStudy(Pictures):
    """Models and sizes of one light's map."""

    axis = "shadow"
    metric, unit, stages = "transmittance", "of the light", ("shadow", "shade")

    def __init__(self, request: Request) -> None:
        super().__init__(request)
        power = [light.intensity * sum(light.colour) * (2 if light.shadow.model != "off" else 1)
                 for light in self.scene.lights]  # fmt: skip
        if not power or max(power) <= 0:
            raise UsageError(f"{request.name}: has no light, and so no shadow to be studied")
        self.light = int(np.argmax(power))
        self.path = f"lights.{self.light}.shadow"
        self.title += f" of light {self.light}"
        self.spacing = self.subject.spacing()

    def choices(self) -> list[Knobs]:
        """Every model, coarse to fine; of deep maps the layers as well."""
        sizes = (32, 64, 128, 256, 512, 1024)
        out: list[Knobs] = [{f"{self.path}.model": "off"}]
        out += [{f"{self.path}.model": "minmax", f"{self.path}.size": size} for size in sizes]
        if knows(self.scene, f"{self.path}.model", "opacity"):
            deep = {f"{self.path}.model": "opacity"}
            out += [{**deep, f"{self.path}.size": size} for size in sizes]
            out += [{**deep, f"{self.path}.layers": layers} for layers in (1, 3, 5, 29)]
            sides = [float(f"{times * self.spacing:.3g}") for times in (0.25, 0.5, 1, 2, 4, 8) if self.spacing > 0]
            out += [{**deep, f"{self.path}.size": FINEST, f"{self.path}.texel": side} for side in sides]
        return [*out, {f"{self.path}.model": "traced"}]

    def series(self, knobs: Knobs) -> str:
        """The model."""
        return str(knobs[f"{self.path}.model"])

    def reference(self) -> dict[str, Any]:
        """Rays from points that are seen and lit."""
        rng = np.random.default_rng(0)
        strands, points, self.lit, self.places = self._light({f"{self.path}.model": "minmax", f"{self.path}.size": 8,
                                                              f"{self.path}.bias": BEYOND})  # fmt: skip
        if not len(self.places):
            raise UsageError(f"{self.subject.name}: light {self.light} reaches no strand that is seen")
        # with exact shadows other vertices are lit: those that are so both ways
        both = np.flatnonzero(np.isin(self.places, self._light({f"{self.path}.model": "traced"})[3]))
        chosen = rng.permutation(both)[:PROBES]
        self.places, self.lit = self.places[chosen], self.lit[chosen]
        points, strands = points[chosen], strands[chosen]
        halves = self._rays(points[:, 1], strands, bundle(RAYS, BUNDLE * self.spacing, rng))
        self.around = halves.mean(1)
        noise = float(np.abs(halves[:, 0] - halves[:, 1]).mean() / 2)
        there, weights = along(points, ALONG)
        own = self._rays(there.reshape(-1, 3), np.repeat(strands, 2 * ALONG), np.zeros((2, 2))).mean(1)
        self.truth = own.reshape(-1, 2 * ALONG) @ weights
        return {"what": f"rays from {len(chosen)} strands that are seen, {2 * ALONG} from each and {RAYS} about it, "
                "against cylinders",
                "light": self.light, "mean": float(self.truth.mean()), "noise": noise, "spacing": self.spacing,
                "radius": BUNDLE * self.spacing}  # fmt: skip

    def measure(self, knobs: Knobs) -> Any:
        """One map: timed with the strands' own material, compared on white ones."""
        picture = self.subject.draw(changed(alone(self.scene, self.light), knobs))
        point = self.point(knobs, picture, self.errors(knobs, picture))
        size = 0 if point.series == "off" else changed(self.scene, knobs).lights[self.light].shadow.size
        point.counts = {**picture.counts, "map_bytes": 8 * size * size} if point.series == "minmax" else picture.counts
        return point

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Mean of the absolute difference of transmittance, signed mean, 95th percentile; mean about the strand."""
        found = np.ones(len(self.truth))
        if knobs[f"{self.path}.model"] != "off":
            light = self._light(knobs)
            order = np.searchsorted(light[3], self.places)
            found = light[2][order] / self.lit
        off = found - self.truth
        around = None if knobs[f"{self.path}.model"] == "traced" else float(np.abs(found - self.around).mean())
        return {"transmittance": float(np.abs(off).mean()), "bias": float(off.mean()),
                "p95": float(np.percentile(np.abs(off), 95)), "around": around}  # fmt: skip

    def _light(
        self, knobs: Knobs
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Of the vertices that the light could reach and the picture shows: strands, places in metres (n, 3, 3) of the
        vertex before, its own and the one behind, light, and their numbers, ascending. With a map's shade some may be
        dark."""
        picture = self.subject.draw(changed(matt(alone(self.scene, self.light)), knobs), draws=1, keep_shading=True)
        strands, points, light, numbers = [], [], [], []
        strand = vertex = 0
        for lines, colours in picture.shaded:
            value = colours.sum(1, dtype=np.float64)
            seen = np.flatnonzero(np.isfinite(value) & ((value > 1e-6) | (f"{self.path}.bias" not in knobs)))
            own = np.searchsorted(lines.first, seen, "right") - 1
            strands.append(strand + own)
            near = [seen - 1, seen, seen + 1]
            sides = np.clip(np.stack(near, 1), lines.first[own, None], lines.first[own + 1, None] - 1)
            points.append(lines.world[sides].astype(np.float64))
            light.append(value[seen])
            numbers.append(vertex + seen)
            strand, vertex = strand + len(lines.first) - 1, vertex + len(lines.world)
        return np.concatenate(strands), np.concatenate(points), np.concatenate(light), np.concatenate(numbers)

    def _rays(
        self, points: NDArray[np.float64], own: NDArray[np.int64], jitter: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        scene = self.scene
        lines = flatten(
            *self.subject.whole(), self.subject.groom.strands, scene.curves, self.subject.view(scene), True, Scratch()
        )
        thickness = Thickness(scene.material.width, scene.material.taper)
        return transmittance(lines, thickness, scene.lights[self.light], points, own, jitter)


def bundle(rays: int, radius: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """(rays, 2) places evenly over a disc, metres: an R2 sequence, shifted at random, which leaves a third of the noise
    of random places."""
    turns = rng.random(2) + np.arange(rays)[:, None] * np.array([1 / PLASTIC, 1 / PLASTIC**2])
    u, v = (turns % 1.0).T
    out = radius * np.sqrt(u)
    return np.stack([out * np.cos(2 * np.pi * v), out * np.sin(2 * np.pi * v)], 1)


def along(points: NDArray[np.float64], rays: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (n, 2 ``rays``, 3) on the way from the first to the second of ``points`` (n, 3, 3) and on to the third,
    and weights that fall to nothing at both ends and add up to 1."""
    t = ((np.arange(rays) + 0.5) / rays)[None, :, None]
    before, here, behind = (points[:, i, None] for i in range(3))
    weights = np.concatenate([t[0, :, 0], 1 - t[0, :, 0]])
    return np.concatenate([before + t * (here - before), here + t * (behind - here)], 1), weights / weights.sum()


def transmittance(
    lines: Polylines, thickness: Thickness, light: Light, points: NDArray[np.float64], own: NDArray[np.int64],
    jitter: NDArray[np.float64],
) -> NDArray[np.float64]:  # fmt: skip
    """(P, 2): what polylines as cylinders leave of a light at ``points`` (P, 3), by the even and the odd rays of a
    bundle ``jitter`` (R, 2) metres wide; ``own`` (P,): the strand that each point is on, which does not count."""
    if isinstance(light, DirectionalLight):
        ways = np.broadcast_to(-np.array(light.direction, np.float64), points.shape)
        reaches = np.full(len(points), np.inf)
    else:
        ways = np.array(light.position) - points
        reaches = np.linalg.norm(ways, axis=1)
    frames = frames_along(ways)
    along = np.concatenate([np.linspace(0, 1, count) for count in np.diff(lines.first)])
    radii = 0.5 * thickness.width * (1 - thickness.taper * along)
    out = np.empty((len(points), 2))
    cylinders.transmittance(
        lines.first, lines.world.astype(np.float64), radii, points, own, frames, reaches, jitter, out
    )
    return out


def frames_along(ways: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, 3, 3): for each of ``ways`` (P, 3) what `draw.camera.axes` has for one, two unit vectors across it and one
    along."""
    along = ways / np.linalg.norm(ways, axis=1, keepdims=True)
    across = np.cross(along, (0.0, 1.0, 0.0))
    upright = np.linalg.norm(across, axis=1) < 1e-9
    across[upright] = np.cross(along[upright], (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.stack([across, np.cross(across, along), along], 1)


def alone(scene: Scene, light: int) -> Scene:
    """A scene with one light that shines, in its place in the list."""
    others = {f"lights.{i}.intensity": 0.0 for i in range(len(scene.lights)) if i != light}
    return changed(scene, others)


def matt(scene: Scene) -> Scene:
    """A scene whose strands scatter what reaches them evenly and colourlessly, and are lit by lamps alone."""
    settings = {"material.colour": (1.0, 1.0, 1.0), "material.tip_colour": None, "material.colour_variation": 0.0,
                "material.specular": 0.0, "material.scatter": "diffuse", "material.diffuse": 1.0,
                "material.pigment": "rgb", "material.eumelanin": None, "material.pheomelanin": None,
                "material.grey": 0.0, "ambient": (0.0, 0.0, 0.0), "environment": None}  # fmt: skip
    return changed(scene, {path: value for path, value in settings.items() if knows(scene, path)})


AXIS = Axis(
    name="shadow",
    doc="models of shadow and sizes of maps against rays and cylinders",
    knobs=("model", "size", "layers", "texel"),
    metric="transmittance",
    of_preset=True,
    open=ShadowStudy,
    pictures=True,
)
