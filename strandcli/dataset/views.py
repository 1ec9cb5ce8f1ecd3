"""What views a data set has, checked before anything is drawn; and what is drawn by chance: where cameras stand, light,
colour. View k depends on the seed, the groom's name and k alone, however many views there are and whatever was drawn
before."""

from __future__ import annotations

import itertools
import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..cameras.pinhole import UP, Floats, Pinhole, upright
from ..common.counted import counted
from ..common.registry import LAYOUTS
from ..common.rotations import xyz
from ..errors import UsageError
from ..groom.emit import PLASTIC
from ..groom_file.measure import framed
from .layout import LAYERS, Layout

if TYPE_CHECKING:
    from ..scene.model import Camera, Scene

PIGMENTS = ("black", "dark_brown", "brown", "light_brown", "auburn", "red", "dark_blond", "blond", "platinum")
PALE = ("blond", "platinum")
"""Burn out in light that brown hair wants; so does grey."""
FILL = (0.72, 0.92)
"""Share of the picture that strands fill."""
STEEPEST = 89.0
"""Degrees above or below the horizon: right above, the picture has no up."""
START, FRAMING, LIGHT, COLOUR = range(4)
"""What streams of random numbers are for."""
SET = 0
"""In place of a view's number, from 1, in streams that all views share."""
EACH, ONE, KEPT = "view", "set", "scene"
"""Light and colour: new for each view, one for the set, as the scene has them."""
OFF = 1e-3
"""Pixels by which a principal point may be off the middle where it has to be there."""
DEFAULT = 8
"""Views."""


@dataclass(frozen=True)
class Chance:
    """The random part of a data set."""

    seed: int
    name: str
    """Of the groom, so that two grooms are not seen from the same places."""
    light: str = EACH
    colour: str = EACH
    azimuth: tuple[float, float] = (-180.0, 180.0)
    """Degrees, from the scene's camera to its right, that cameras stand at."""
    elevation: tuple[float, float] = (-10.0, 40.0)
    """Degrees above the horizon."""

    def stream(self, what: int, view: int | None = None) -> np.random.Generator:
        """The random numbers of a view, or of the set."""
        number = SET if view is None else view + 1
        return np.random.default_rng([self.seed, zlib.crc32(self.name.encode()), what, number])

    def direction(self, view: int, base: Camera) -> tuple[Floats, float]:
        """From what is looked at to the camera of a view, a unit vector, and its azimuth in radians.

        Views follow an additive recurrence in two dimensions (Roberts 2018), which spreads any number of them evenly.
        """
        u, v = (self.stream(START).random(2) + view * np.array([1 / PLASTIC, 1 / PLASTIC**2])) % 1.0
        x, _, z = np.subtract(base.position, base.target)
        azimuth = math.atan2(x, z) + math.radians(_between(u, self.azimuth))
        low, high = (math.sin(math.radians(min(max(one, -STEEPEST), STEEPEST))) for one in self.elevation)
        height = _between(v, (low, high))
        flat = math.sqrt(1 - height * height)
        return np.array([flat * math.sin(azimuth), height, flat * math.cos(azimuth)]), azimuth


def _between(share: float, bounds: tuple[float, float]) -> float:
    return bounds[0] + share * (bounds[1] - bounds[0])


def camera_of(chance: Chance, view: int, base: Camera, points: Floats, size: tuple[int, int]) -> Camera:
    """The camera of a view, which has the base's projection and sees all points (k, 3)."""
    away, _ = chance.direction(view, base)
    fit = float(chance.stream(FRAMING, view).uniform(*FILL))
    x, y, z = (float(one) for one in away)
    turned = replace(base, position=(x, y, z), target=(0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), fit=fit)
    return framed(turned, points, size)


def lit(
    scene: Scene, chance: Chance, view: int, place: Pinhole, above: tuple[float, float, float] = UP
) -> tuple[Scene, dict[str, Any]]:
    """The scene in the light and colour of a view from a place, and what they are, for the manifest; ``above``: the
    unit vector that is up."""
    facts: dict[str, Any] = {}
    pale = 0.0
    if chance.colour != KEPT:
        rng = chance.stream(COLOUR, view if chance.colour == EACH else None)
        pigment, grey = str(rng.choice(PIGMENTS)), max(float(rng.uniform(-0.5, 0.5)), 0.0)
        spread = float(rng.uniform(0.1, 0.4))
        pale = max(0.45 * (pigment in PALE), 0.5 * grey)
        facts["colour"] = {"pigment": pigment, "grey": grey, "colour_variation": spread}
        changed = {"eumelanin": None, "pheomelanin": None, "tip_colour": None, **facts["colour"]}
        scene = replace(scene, material=replace(scene.material, **changed))
    if chance.light != KEPT:
        each = chance.light == EACH
        rng = chance.stream(LIGHT, view if each else None)
        axes = _axes(place, np.array(above)) if each else upright(above).T
        lights = _lights(scene, rng, axes, 1 - pale)
        around = rng.uniform(0.3, 0.6) * rng.uniform([0.9, 0.95, 0.9], [1.0, 1.0, 1.1])
        behind = float(rng.uniform(0.02, 0.4)) * rng.uniform(0.9, 1.1, 3)
        scene = replace(
            scene, lights=lights, ambient=xyz(around), environment=None,
            image=replace(scene.image, background=xyz(behind), horizon=None),
        )  # fmt: skip
        facts["light"] = {
            "ambient": list(scene.ambient),
            "background": list(scene.image.background),
            "lights": [
                {"direction": list(one.direction), "intensity": one.intensity, "size": one.size,
                 "colour": list(one.colour)} for one in lights
            ],
        }  # fmt: skip
    return scene, facts


def _axes(place: Pinhole, up: Floats) -> Floats:
    """(3, 3) rows: to the right of a camera, up, and back to it, of which up is that of the world unless the camera
    looks along it, or lies on its side."""
    back = -place.rotation[2]
    flat = float(np.linalg.norm(back - (back @ up) * up))
    if abs(back @ up) > math.sin(math.radians(STEEPEST)) or -place.rotation[1] @ up < 0.3 * flat:
        up = -place.rotation[1]
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    return np.stack([right, up, np.cross(right, up)])


def _lights(scene: Scene, rng: np.random.Generator, axes: Floats, power: float) -> tuple[Any, ...]:
    """Two lights, as a photographer sets them up: a key light from the camera's side, and one from behind, in some
    pictures next to none. What fills the shadows is the light from everywhere."""
    from ..scene.model import DirectionalLight, Shadow

    given = next((one.shadow for one in scene.lights if one.shadow.model == "opacity"), None)
    shadow = Shadow(model="opacity") if given is None else given
    hand = 1.0 if rng.uniform(-1, 1) > 0 else -1.0
    key = power * float(rng.uniform(2.5, 4.5))
    parts = (
        (hand * rng.uniform(10, 65), rng.uniform(-1.1, -0.25), key, rng.uniform(3, 15)),
        (-hand * rng.uniform(120, 200), rng.uniform(-0.8, -0.15), key * rng.uniform(0.05, 0.6), rng.uniform(3, 15)),
    )
    lights = []
    for number, (turn, down, intensity, size) in enumerate(parts):
        around = math.radians(float(turn))
        direction = np.array([-math.sin(around), float(down), -math.cos(around)]) @ axes
        tint = (1.0, float(rng.uniform(0.88, 1.0)), float(rng.uniform(0.75, 1.0)))
        lights.append(
            DirectionalLight(
                direction=xyz(direction),
                intensity=float(intensity),
                size=float(size),
                colour=tint,
                shadow=shadow if number == 0 else Shadow(model="opacity"),
            )
        )
    return tuple(lights)


def layout_of(name: str) -> Layout:
    """The layout of a name. Raises `UsageError` where there is none."""
    names = LAYOUTS.names()
    if name not in names:
        raise UsageError(f"--layout {name}: layouts are {', '.join(names)}")
    found: Layout = LAYOUTS[name]
    return found


def size_for(
    layout: Layout, given: tuple[int, int] | None, places: Sequence[Pinhole], path: Path | None
) -> tuple[int, int]:
    """Width and height of the pictures. Raises `UsageError` where a layout cannot hold them."""
    size = given or layout.size
    if places:
        size = _size_of(places, layout, path)
    if layout.square and size[0] != size[1]:
        where = f"{path}: " if places else "--size "
        raise UsageError(f"{where}{size[0]}x{size[1]}: the layout {layout.name} has square pictures alone")
    return size


def _size_of(places: Sequence[Pinhole], layout: Layout, path: Path | None) -> tuple[int, int]:
    """The size of all views of a file."""
    sizes = sorted({(one.width, one.height) for one in places})
    if len(sizes) > 1:
        listed = " and ".join(f"{width}x{height}" for width, height in sizes[:2])
        raise UsageError(f"{path}: views are of several sizes, {listed} for two; a data set has one")
    size = sizes[0]
    for one in places:
        if one.perspective != layout.perspective:
            kind = "perspective" if layout.perspective else "orthographic"
            raise UsageError(f"{path}: view {one.name}: the layout {layout.name} has {kind} views alone")
        off = max(abs(one.centre[0] - size[0] / 2), abs(one.centre[1] - size[1] / 2))
        if layout.centred and off > OFF:
            raise UsageError(
                f"{path}: view {one.name}: its principal point is {off:.3g} pixels off the middle, where programs that "
                f"read {layout.name} take it to be; choose neuralhaircut or nerfstudio"
            )
    return size


def numbers_for(count: int | None, first: int, places: Sequence[Pinhole], path: Path | None) -> range:
    """The numbers of the views. Raises `UsageError` where a file of cameras has fewer."""
    if count is None:
        count = max(len(places) - first, 1) if places else DEFAULT
    if places and first + count > len(places):
        raise UsageError(f"--views: {path} holds {counted(len(places), 'view')}, {first + count} are asked for")
    return range(first, first + count)


def scene_for(scene: Scene, layout: Layout, size: tuple[int, int], frame: int) -> Scene:
    """A scene as views of a data set are drawn: of a size, through a pinhole that keeps still, with the layers that
    labels are made of. Raises `UsageError` for a scene without layers, or without such a frame."""
    if scene.panels:
        raise UsageError("a preset of several panels has no labels; take one without panels")
    if scene.image.has_alpha:
        raise UsageError("image.background: a data set has masks beside its pictures, not alpha in them; name a colour")
    if frame > scene.time.frames:
        raise UsageError(f"--frame {frame}: the preset has {scene.time.frames} frames")
    from ..scene.motion import camera_at

    now = camera_at(scene.camera, (frame - 1) / scene.time.fps)
    camera = replace(
        scene.camera, kind="perspective" if layout.perspective else "orthographic", position=now.position,
        target=now.target, aperture=0.0, shutter=0.0, keys=(), axis_x=0.5, axis_y=0.5,
        file=None, name="", views=(),
    )  # fmt: skip
    return replace(scene, camera=camera, image=replace(scene.image, size=size, crop=None, aovs=LAYERS))


def names_of(grooms: Sequence[str]) -> list[str]:
    """A name for each groom, one part of a path: that of its file without its end; a number goes to those whose name
    another has."""
    found: list[str] = []
    for groom in grooms:
        stem = Path(groom).stem
        name = plain = stem if stem.strip(".") else "groom"
        for number in itertools.count(2):
            if name not in found:
                break
            name = f"{plain}-{number}"
        found.append(name)
    return found
