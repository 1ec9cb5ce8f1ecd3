"""Shadow: models of the brightest light's shadow against rays that meet strands as cylinders.

What is compared is the share of light that reaches the points the picture shows, as the picture has it: the light on
matt white strands with the shadow, over that without. There are two questions. `transmittance` asks for the strand's
own light, over as much of its length as the picture takes together: to the next vertices that are lit, or a pixel; a
map, which blurs the shadows of single strands, has no such answer to give. `around` asks for the mean over a bundle of
rays, wider than strands are apart there, as pictures of hair much thinner than a pixel show it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.common.scratch import Scratch
from ...draw.geometry.curves import Polylines, flatten
from ...draw.geometry.extent import Thickness
from ...draw.view.camera import View
from ...errors import UsageError
from ...groom.emit import PLASTIC
from ...registry import SHADOWS
from ...scene.model import DirectionalLight, Light, Scene
from ..axes import Request
from ..kernels import cylinders
from ..points import Knobs
from ..settings import changed, knows
from .experiment import Pictures
from .subject import Picture, on_screen

PROBES = 400
RAYS = 2048
"""From about a probe: with 256 their noise, .02 in `hair`, was as much as maps are off."""
BUNDLE = 1.5
"""Radius of a probe's bundle of rays, in distances between strands there."""
ALONG = 128
"""Rays from a probe's strand on each side of it: what a strand leaves of a light's way is some tenths of a millimetre
wide, and a picture takes centimetres together."""
FARTHEST = 32
"""Pieces to each side of a vertex that a picture averages light over, at most."""
BEYOND = 1e9
"""Metres: a bias behind which nothing is, for the light without a map's shade."""
TINY = 1e-12
STEEPEST = 4.0
"""Greatest tangent of a strand's slant to the view."""


@dataclass
class Lit:
    """Vertices of strands that a light reaches."""

    shown: list[Polylines]
    """All strands, in portions, whose vertices are numbered on."""
    light: NDArray[np.float64]
    """(n,)"""
    numbers: NDArray[np.int64]
    """(n,) of the vertices, ascending."""

    def about(
        self, chosen: NDArray[np.int64], view: View, thickness: Thickness, rays: int
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Of some of these: their places (n, 3), metres, and strands (n,); and on each strand ``rays`` places to each
        side (n, 2 rays, 3) with weights (n, 2 rays) that add up to 1: on the half of its surface that ``view`` shows,
        evenly across, and along it by a hat over the length that a picture takes together."""
        begins = np.cumsum([0, *(len(lines.world) for lines in self.shown)])
        strands = np.cumsum([0, *(len(lines.first) - 1 for lines in self.shown)])
        t = (np.arange(2 * rays) + 0.5) / rays - 1.0
        h = 2 * (np.arange(2 * rays) / PLASTIC % 1.0) - 1.0
        points, own, spots = np.empty((len(chosen), 3)), np.empty(len(chosen), np.int64), []
        weights = np.tile(1.0 - np.abs(t), (len(chosen), 1))
        for row, number in enumerate(self.numbers[chosen]):
            portion = int(np.searchsorted(begins, number, "right")) - 1
            lines, vertex = self.shown[portion], int(number - begins[portion])
            s = int(np.searchsorted(lines.first, vertex, "right")) - 1
            strand = lines.world[lines.first[s] : lines.first[s + 1]].astype(np.float64)
            v = vertex - int(lines.first[s])
            points[row], own[row] = strand[v], strands[portion] + s
            before = min(v, len(strand) - 2)
            long = math.dist(*on_screen(strand[before : before + 2], view)[0])
            far = max(lines.stride, math.ceil(min(1.0 / max(long, TINY), FARTHEST)))
            at = v + far * t
            weights[row] *= (at >= 0) & (at <= len(strand) - 1)
            radius = 0.5 * thickness.width * (1 - thickness.taper * np.clip(at / max(len(strand) - 1, 1), 0, 1))
            spots.append(on_surface(strand, at, radius, h, view))
        return points, own, np.stack(spots), weights / weights.sum(1, keepdims=True)


def on_surface(
    strand: NDArray[np.float64], at: NDArray[np.float64], radius: NDArray[np.float64], h: NDArray[np.float64],
    view: View,
) -> NDArray[np.float64]:  # fmt: skip
    """(k, 3): where a view sees the offsets h (k,) ∈ [−1, 1] across a polyline (n, 3) as a tube of ``radius`` (k,), at
    as many places ``at`` along it, in vertices: aside, and toward the eye so far that it shows them at their place."""
    vertices = np.arange(len(strand))
    places = np.stack([np.interp(at, vertices, column) for column in strand.T], 1)
    way = np.gradient(strand, axis=0)[np.clip(at.round().astype(np.int64), 0, len(strand) - 1)]
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), TINY)
    eye = view.eye - places if view.perspective else np.broadcast_to(-view.forward, places.shape)
    eye = eye / np.linalg.norm(eye, axis=1, keepdims=True)
    aside = np.cross(way, eye)
    sine = np.maximum(np.linalg.norm(aside, axis=1), 1 / STEEPEST)[:, None]
    return places + radius[:, None] * (h[:, None] * aside + np.sqrt(1 - h * h)[:, None] * eye) / sine


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

    def choices(self) -> list[Knobs]:
        """Every model, coarse to fine; of deep maps the layers as well."""

        def spacing() -> float:
            self.subject.move()  # how far strands lie apart tells which texels to try
            return float(self.subject.spacing())

        names = sorted(SHADOWS.names(), key=lambda name: name != "off")  # the picture without shadows first
        return [knobs for name in names for knobs in SHADOWS[name].study(self.path, spacing)]

    def series(self, knobs: Knobs) -> str:
        """The model."""
        return str(knobs[f"{self.path}.model"])

    def reference(self) -> dict[str, Any]:
        """Rays from points that are seen and lit."""
        rng = np.random.default_rng(0)
        lit = self._light({f"{self.path}.model": "minmax", f"{self.path}.size": 8, f"{self.path}.bias": BEYOND})
        if not len(lit.numbers):
            raise UsageError(f"{self.subject.name}: light {self.light} reaches no strand that is seen")
        chosen = rng.permutation(len(lit.numbers))[:PROBES]
        self.places, self.lit = lit.numbers[chosen], lit.light[chosen]
        points, strands, spots, weights = lit.about(chosen, self._samples(), self._thickness(), ALONG)
        spacing = self.subject.spacing_at(points, strands)
        halves = self._rays(points, strands, bundle(RAYS, BUNDLE, rng), spacing)
        self.around = halves.mean(1)
        noise = float(np.abs(halves[:, 0] - halves[:, 1]).mean() / 2)
        own = self._rays(spots.reshape(-1, 3), np.repeat(strands, 2 * ALONG), np.zeros((2, 2)), 1.0).mean(1)
        self.truth = (own.reshape(-1, 2 * ALONG) * weights).sum(1)
        return {"what": f"rays from {len(chosen)} strands that are seen, {2 * ALONG} from each and {RAYS} about it, "
                "against cylinders",
                "light": self.light, "mean": float(self.truth.mean()), "noise": noise,
                "spacing": float(np.median(spacing)), "radius": BUNDLE * float(np.median(spacing))}  # fmt: skip

    def measure(self, knobs: Knobs) -> Any:
        """One map: timed with the strands' own material, compared on white ones."""
        picture = self.subject.draw(changed(alone(self.scene, self.light), knobs))
        point = self.point(knobs, picture, self.errors(knobs, picture))
        shadow, model = changed(self.scene, knobs).lights[self.light].shadow, SHADOWS[point.series]
        flat = model.casts_map(True) and model.layers(shadow) == 0
        point.counts = {**picture.counts, "map_bytes": 8 * model.side_of(shadow) ** 2} if flat else picture.counts
        return point

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Mean of the absolute difference of transmittance, signed mean, 95th percentile; mean about the strand."""
        found = np.ones(len(self.truth))
        if knobs[f"{self.path}.model"] != "off":
            light = self._light(knobs)
            found = light.light[np.searchsorted(light.numbers, self.places)] / self.lit
        off = found - self.truth
        around = float(np.abs(found - self.around).mean())
        return {"transmittance": float(np.abs(off).mean()), "bias": float(off.mean()),
                "p95": float(np.percentile(np.abs(off), 95)), "around": around}  # fmt: skip

    def _light(self, knobs: Knobs) -> Lit:
        """The vertices that the light could reach and the picture shows. With a map's shade some may be dark."""
        picture = self.subject.draw(changed(matt(alone(self.scene, self.light)), knobs), draws=1, keep_shading=True)
        shown, light, numbers = [], [], []
        vertex = 0
        for lines, colours in picture.shaded:
            value = colours.sum(1, dtype=np.float64)
            seen = np.flatnonzero(np.isfinite(value) & ((value > 1e-6) | (f"{self.path}.bias" not in knobs)))
            shown.append(lines)
            light.append(value[seen])
            numbers.append(vertex + seen)
            vertex += len(lines.world)
        return Lit(shown, np.concatenate(light), np.concatenate(numbers))

    def _samples(self) -> View:
        """The camera, in samples."""
        image, view = self.scene.image, self.subject.view(self.scene)
        n = image.supersample
        return replace(view, focal=n * view.focal, width=n * view.width, height=n * view.height)

    def _rays(
        self, points: NDArray[np.float64], own: NDArray[np.int64], jitter: NDArray[np.float64],
        wide: NDArray[np.float64] | float,
    ) -> NDArray[np.float64]:  # fmt: skip
        scene = self.scene
        lines = flatten(
            *self.subject.whole(), self.subject.groom.strands, scene.curves, self.subject.view(scene), True, Scratch()
        )
        return transmittance(lines, self._thickness(), scene.lights[self.light], points, own, jitter, wide)

    def _thickness(self) -> Thickness:
        return Thickness(self.scene.material.width, self.scene.material.drawn_taper)


def bundle(rays: int, radius: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """(rays, 2) places evenly over a disc, metres: an R2 sequence, shifted at random, which leaves a third of the noise
    of random places."""
    turns = rng.random(2) + np.arange(rays)[:, None] * np.array([1 / PLASTIC, 1 / PLASTIC**2])
    u, v = (turns % 1.0).T
    out = radius * np.sqrt(u)
    return np.stack([out * np.cos(2 * np.pi * v), out * np.sin(2 * np.pi * v)], 1)


def transmittance(
    lines: Polylines, thickness: Thickness, light: Light, points: NDArray[np.float64], own: NDArray[np.int64],
    jitter: NDArray[np.float64], wide: NDArray[np.float64] | float = 1.0,
) -> NDArray[np.float64]:  # fmt: skip
    """(P, 2): what polylines as cylinders leave of a light at ``points`` (P, 3), by the even and the odd rays of a
    bundle ``jitter`` (R, 2) that is ``wide`` (P,) times as many metres wide; ``own`` (P,): the strand that each point
    is on, which does not count."""
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
        lines.first,
        lines.world.astype(np.float64),
        radii,
        points,
        own,
        frames,
        reaches,
        jitter,
        np.broadcast_to(np.asarray(wide, np.float64), len(points)).copy(),
        out,
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
