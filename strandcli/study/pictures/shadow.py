"""Shadow: models of the brightest light's shadow against rays that meet strands as cylinders.

What is compared is the share of light that reaches the points that the picture shows, the light on matt white strands
with the shadow over that without, with the mean over a bundle of rays. Bundles are wider than strands are apart there,
as pictures of hair much thinner than a pixel show it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.registry import SHADOWS
from ...draw.common.scratch import Scratch
from ...draw.geometry.curves import Polylines, flatten
from ...draw.geometry.extent import Thickness
from ...draw.strand_batches import StrandBatch
from ...errors import UsageError
from ...groom.emit import PLASTIC
from ...scene.model import DirectionalLight, Light, Scene
from ..kernels import cylinders
from ..points import Parameters
from ..sweep import Request, changed, knows
from .frame import Pictures
from .subject import LinearRenderer, Picture, Subject

PROBES = 400
RAYS = 2048
"""From about a probe: with 256 their noise, .02 in `hair`, was as much as maps are off."""
BUNDLE = 1.5
"""Radius of a probe's bundle of rays, in distances between strands there."""
DARK = 1e-6
"""Light below which a vertex tells nothing."""
BEYOND = 1e9
"""Metres: a bias behind which nothing is, for the light without a map's shade."""


class Vertices(NamedTuple):
    """Vertices of strands that a picture shows."""

    light: NDArray[np.float64]
    """(n,) of red, green and blue together."""
    numbers: NDArray[np.int64]
    """(n,) ascending."""
    places: NDArray[np.float64]
    """(n, 3) metres."""
    strands: NDArray[np.int64]
    """(n,) that they are on."""


class ShadingRenderer(LinearRenderer):
    """Keeps the light at vertices: those of hidden strands too, which pictures of thin strands show as well."""

    def draw(self, *args: Any, **kwargs: Any) -> Any:
        self.shaded: dict[int, tuple[Polylines, NDArray[np.float32]]] = {}
        """By the first strand of a batch; NaN where no light was needed."""
        return super().draw(*args, **kwargs)

    def shade(self, lighting: Any, batch: StrandBatch, *rest: Any) -> NDArray[np.float32]:
        lines, begin = batch.lines, batch.begin
        self.scratch.borrow("colours", (len(lines.world), 3), np.float32).fill(np.nan)
        colours = super().shade(lighting, batch, *rest)
        if begin in self.shaded:  # the picture's next rows show more of the same strands
            light = self.shaded[begin][1]
            np.copyto(light, colours, where=np.isnan(light))
        else:
            lines = replace(lines, first=lines.first.copy(), world=lines.world.copy())
            self.shaded[begin] = lines, colours.copy()
        return colours

    def vertices(self, least: float) -> Vertices:
        """The vertices whose light was needed and is above ``least``."""
        found: list[tuple[NDArray[Any], ...]] = []
        vertex = strand = 0
        for lines, colours in self.shaded.values():
            light = colours.sum(1, dtype=np.float64)
            seen = np.flatnonzero(light > least)
            strands = np.searchsorted(lines.first, seen, "right") - 1
            found.append((light[seen], vertex + seen, lines.world[seen].astype(np.float64), strand + strands))
            vertex, strand = vertex + len(lines.world), strand + len(lines.first) - 1
        return Vertices(*map(np.concatenate, zip(*found, strict=True)))


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

    def opened(self, request: Request) -> Subject:
        """The first strands, small."""
        return Subject(request)

    def choices(self) -> list[Parameters]:
        """Every model, coarse to fine; of deep maps the layers as well."""

        def spacing() -> float:
            self.subject.move()  # how far strands lie apart tells which texels to try
            return float(self.subject.spacing())

        names = sorted(SHADOWS.names(), key=lambda name: name != "off")  # the picture without shadows first
        return [parameters for name in names for parameters in SHADOWS[name].study(self.path, spacing)]

    def series(self, parameters: Parameters) -> str:
        """The model."""
        return str(parameters[f"{self.path}.model"])

    def reference(self) -> dict[str, Any]:
        """Rays from points that are seen and lit."""
        rng = np.random.default_rng(0)
        lit = self._light({f"{self.path}.model": "minmax", f"{self.path}.size": 8, f"{self.path}.bias": BEYOND})
        if not len(lit.numbers):
            raise UsageError(f"{self.subject.name}: light {self.light} reaches no strand that is seen")
        chosen = rng.permutation(len(lit.numbers))[:PROBES]
        self.lit, self.numbers = lit.light[chosen], lit.numbers[chosen]
        points, own = lit.places[chosen], lit.strands[chosen]
        spacing = self.subject.spacing_at(points, own)
        scene, subject = self.scene, self.subject
        lines = flatten(*subject.whole(), subject.groom.strands, scene.curves, subject.view(scene), True, Scratch())
        thickness = Thickness(scene.material.width, scene.material.drawn_taper)
        jitter = bundle(RAYS, BUNDLE, rng)
        halves = transmittance(lines, thickness, scene.lights[self.light], points, own, jitter, spacing)
        self.truth = halves.mean(1)
        noise = float(np.abs(halves[:, 0] - halves[:, 1]).mean() / 2)
        return {"what": f"{RAYS} rays about each of {len(chosen)} strands that are seen, against cylinders",
                "light": self.light, "mean": float(self.truth.mean()), "noise": noise,
                "spacing": float(np.median(spacing)), "radius": BUNDLE * float(np.median(spacing))}  # fmt: skip

    def measure(self, parameters: Parameters) -> Any:
        """One map: timed with the strands' own material, compared on white ones."""
        picture = self.subject.draw(changed(alone(self.scene, self.light), parameters))
        return self.point(parameters, picture, self.errors(parameters, picture))

    def errors(self, parameters: Parameters, picture: Picture) -> dict[str, float | None]:
        """Mean of the absolute difference of transmittance, signed mean, 95th percentile."""
        found = np.ones(len(self.truth))
        if parameters[f"{self.path}.model"] != "off":
            light = self._light(parameters, -1.0)
            found = light.light[np.searchsorted(light.numbers, self.numbers)] / self.lit
        off = found - self.truth
        return {"transmittance": float(np.abs(off).mean()), "bias": float(off.mean()),
                "p95": float(np.percentile(np.abs(off), 95))}  # fmt: skip

    def _light(self, parameters: Parameters, least: float = DARK) -> Vertices:
        """The vertices of white strands that the picture shows, lit by more than ``least``."""
        renderer = ShadingRenderer(changed(matt(alone(self.scene, self.light)), parameters), self.subject.groom)
        self.subject.draw(renderer.scene, 1, renderer)
        return renderer.vertices(least)


def bundle(rays: int, radius: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """(rays, 2) places evenly over a disc, metres: an R2 sequence, shifted at random, which leaves a third of the noise
    of random places."""
    turns = rng.random(2) + np.arange(rays)[:, None] * np.array([1 / PLASTIC, 1 / PLASTIC**2])
    u, v = (turns % 1.0).T
    out = radius * np.sqrt(u)
    return np.stack([out * np.cos(2 * np.pi * v), out * np.sin(2 * np.pi * v)], 1)


def transmittance(
    lines: Polylines, thickness: Thickness, light: Light, points: NDArray[np.float64], own: NDArray[np.int64],
    jitter: NDArray[np.float64], wide: NDArray[np.float64],
) -> NDArray[np.float64]:  # fmt: skip
    """(P, 2): what polylines as cylinders leave of a light at ``points`` (P, 3), by the even and the odd rays of a
    bundle ``jitter`` (R, 2) that is ``wide`` (P,) times as many metres wide; ``own`` (P,): the strand that each point
    is on, which does not count."""
    if isinstance(light, DirectionalLight):
        directions = np.broadcast_to(-np.array(light.direction, np.float64), points.shape)
        reaches = np.full(len(points), np.inf)
    else:
        directions = np.array(light.position) - points
        reaches = np.linalg.norm(directions, axis=1)
    frames = frames_along(directions)
    along = np.concatenate([np.linspace(0, 1, count) for count in np.diff(lines.first)])
    radii = 0.5 * thickness.width * (1 - thickness.taper * along)
    out = np.empty((len(points), 2))
    pieces = pieces_of(lines.first, lines.world.astype(np.float64), radii)
    cylinders.transmittance(pieces, points, own, frames, reaches, jitter, wide, out)
    return out


def pieces_of(first: NDArray[np.integer], world: NDArray[np.float64], radii: NDArray[np.float64]) -> cylinders.Pieces:
    """Polylines, whose vertices world (V, 3) with radii (V,) begin at first (S + 1,), as pieces."""
    begin = np.delete(np.arange(len(world)), first[1:] - 1)
    a, b, widths = world[begin], world[begin + 1], 0.5 * (radii[begin] + radii[begin + 1])
    strands = np.repeat(np.arange(len(first) - 1), np.diff(first) - 1)
    return cylinders.Pieces(a, b, widths, np.linalg.norm(b - a, axis=1), strands)


def frames_along(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, 3, 3): for each of ``directions`` (P, 3) two vectors across and one along, as `draw.view.camera.axes`."""
    along = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    across = np.cross(along, (0.0, 1.0, 0.0))
    upright = np.linalg.norm(across, axis=1) < 1e-9
    across[upright] = np.cross(along[upright], (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.stack([across, np.cross(across, along), along], 1)


def alone(scene: Scene, light: int) -> Scene:
    """A scene with one light that shines, in its place in the list."""
    dark = {f"lights.{i}.intensity": 0.0 for i in range(len(scene.lights)) if i != light}
    return changed(scene, dark)


def matt(scene: Scene) -> Scene:
    """A scene whose strands scatter what reaches them evenly and colourlessly, and are lit by lamps alone."""
    settings = {"material.colour": (1.0, 1.0, 1.0), "material.tip_colour": None, "material.colour_variation": 0.0,
                "material.specular": 0.0, "material.scatter": "diffuse", "material.diffuse": 1.0,
                "material.pigment": "rgb", "material.eumelanin": None, "material.pheomelanin": None,
                "material.grey": 0.0, "ambient": (0.0, 0.0, 0.0), "environment": None}  # fmt: skip
    return changed(scene, {path: value for path, value in settings.items() if knows(scene, path)})
