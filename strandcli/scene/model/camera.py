"""The point of view, the picture, and the lights with their shadow maps."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from ...common.registry import SHADOWS
from ..fields import (
    Colour,
    Vector,
    choice,
    colour,
    file,
    integer,
    items,
    model,
    names,
    number,
    parameters,
    size,
    text,
    vector,
    window,
)  # fmt: skip
from ..specs import NO_COLOUR


@dataclass(frozen=True, slots=True, repr=False)
class CameraKey:
    """The camera at one moment."""

    time: float = number(0.0, unit="s", doc="frame 1 is at 0")
    position: Vector | None = vector(None, unit="m", doc="position of the eye; absent: the camera's")
    target: Vector | None = vector(None, unit="m", doc="point looked at; absent: the camera's")
    fov: float | None = number(
        None, above=0, below=180, unit="deg", doc="vertical field of view (perspective); absent: the camera's"
    )
    height: float | None = number(
        None, above=0, unit="m", doc="height of the view (orthographic); absent: the camera's"
    )
    ease: str = choice("smooth", ("smooth", "linear", "step"), doc="interpolation to the next key")


@dataclass(frozen=True, slots=True, repr=False)
class Camera:
    """The point of view."""

    kind: str = choice("perspective", ("perspective", "orthographic"), doc="projection")
    position: Vector = vector((0.0, 0.0, 5.0), unit="m", doc="position of the eye")
    target: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="point looked at")
    up: Vector = vector((0.0, 1.0, 0.0), unit="1", nonzero=True, doc="direction that is up in the picture")
    fov: float = number(40.0, above=0, below=180, unit="deg", doc="vertical field of view (perspective)")
    height: float = number(3.0, above=0, unit="m", doc="height of the view (orthographic)")
    axis_x: float = number(0.5, doc="principal point, as a fraction of the width from the left")
    axis_y: float = number(0.5, doc="principal point, as a fraction of the height from the top")
    near: float = number(0.01, above=0, unit="m", doc="near clipping distance")
    fit: float | None = number(
        None, above=0, high=10,
        doc="fraction of the picture that strands of a file fill: the camera keeps its direction and moves; "
        "absent: it does not move",
    )  # fmt: skip
    aperture: float = number(
        0.0, low=0, high=1000, unit="m", doc="diameter of the lens (perspective); 0: a pinhole, sharp everywhere"
    )
    focus: float | None = number(None, above=0, unit="m", doc="depth that is sharp; absent: that of the target")
    shutter: float = number(
        0.0,
        low=0,
        high=1,
        doc="fraction of a frame for which the shutter is open, up to the frame's time; 0.5 is usual",
    )
    samples: int = integer(16, low=1, high=4096, doc="pictures averaged over lens and shutter, if either is open")
    keys: tuple[CameraKey, ...] = items(CameraKey, doc="motion")
    file: str | None = file(
        "cameras",
        None,
        doc="camera file with a view per frame: transforms.json, COLMAP's cameras.txt, dataset.json, USD; absent: none",
    )
    name: str = text("", doc="camera of a USD file that has several: its path, or the end of it")
    views: tuple[Camera, ...] = ()
    """Of ``file``; no setting of its own."""


AOVS = ("depth", "mask", "solid", "tangent", "orientation", "strand_id", "shadow", "linear")
"""Layers beside the picture; what each holds is described in `strandcli.draw.film.aovs`."""


@dataclass(frozen=True, slots=True, repr=False)
class Image:
    """The picture."""

    size: tuple[int, int] = size((800, 600), high=32_768, doc='width and height, as [w, h] or "800x600"')
    supersample: int = integer(1, low=1, high=8, doc="samples along each side of a pixel")
    background: Colour | Literal["none"] = colour(
        (0.03, 0.035, 0.045),
        or_none=True,
        doc="background colour, with horizon that at the top; none: a picture with alpha",
    )
    horizon: Colour | None = colour(None, doc="background colour at the bottom, dithered; absent: one colour")
    haze: float | None = number(
        None,
        above=0,
        unit="m",
        doc="depth at which haze leaves 1/e of the light, the rest being background; absent: none",
    )
    exposure: float = number(0.0, low=-20, high=20, unit="stops", doc="light is scaled by 2 ** exposure")
    resolver: str = choice(
        "zbuffer",
        ("zbuffer", "sorted"),
        doc="strands of a pixel. zbuffer: the nearest, as a hard line; sorted: all, by depth and coverage",
    )
    tone: str = choice("srgb", ("srgb", "filmic"), doc="srgb: light is clipped at 1; filmic: it rolls off")
    crop: tuple[int, int, int, int] | None = window(high=32_768, doc="window that is drawn; absent: all")
    aovs: tuple[str, ...] = names(doc=f"layers written beside each picture, of {', '.join(AOVS)}")

    @property
    def drawn(self) -> tuple[int, int]:
        """Width and height of what is drawn: of the crop window, where there is one."""
        return self.size if self.crop is None else self.crop[2:]

    @property
    def has_alpha(self) -> bool:
        """Whether pictures have no background, but alpha."""
        return self.background == NO_COLOUR

    @property
    def channels(self) -> int:
        """Of a picture: red, green and blue, and alpha where it has no background."""
        return 4 if self.has_alpha else 3


@dataclass(frozen=True, slots=True, repr=False)
class Shadow:
    """Shadows of strands in one light: by the thesis' map (§3, corrected), or a deep opacity map."""

    model: str = choice("minmax", SHADOWS, doc="minmax: depth range per texel; opacity: deep opacity map; off: none")
    size: int | None = integer(
        None, low=1, high=8192, unit="texels",
        doc="texels per side, for opacity at most; absent: 512, for opacity 1024",
    )  # fmt: skip
    layers: int = integer(31, low=1, high=61, doc="layers of an opacity map")
    texel: float | None = number(
        None, above=0, unit="m", doc="size of a texel of an opacity map; absent: from the spacing of strands"
    )
    bias: float = number(0.0, low=0, unit="m", doc="depth bias")
    parameters: Any = parameters(SHADOWS, "model", doc="settings of a model of another package; absent: its defaults")


@dataclass(frozen=True, slots=True, repr=False)
class DirectionalLight:
    """Light from infinitely far, like the sun."""

    kind: str = choice("directional", ("directional",))
    direction: Vector = vector((-0.5, -1.0, -0.5), unit="1", nonzero=True, doc="direction in which light travels")
    colour: Colour = colour((1.0, 1.0, 1.0), doc="colour")
    intensity: float = number(3.0, low=0, doc="irradiance on a surface that faces it")
    size: float = number(
        0.0, low=0, high=90, unit="deg", doc="angular diameter, 0.53 for the sun: solids get soft shadows"
    )
    shadow: Shadow = model(Shadow, doc="the strands' shadow map")


@dataclass(frozen=True, slots=True, repr=False)
class PointLight:
    """Light from a point, falling off with the square of the distance."""

    kind: str = choice("point", ("point",))
    position: Vector = vector((3.0, 3.0, 3.0), unit="m", doc="position of the light")
    colour: Colour = colour((1.0, 1.0, 1.0), doc="colour")
    intensity: float = number(30.0, low=0, unit="W/sr", doc="irradiance at one metre")
    size: float = number(0.0, low=0, unit="m", doc="diameter: solids get soft shadows")
    shadow: Shadow = model(Shadow, doc="the strands' shadow map")


Light = DirectionalLight | PointLight
MOST_LIGHTS = 256
"""Lights of a preset at the most: each is drawn into a shadow map of its own, and met by every strand."""
LIGHTS = {"directional": DirectionalLight, "point": PointLight}


@dataclass(frozen=True, slots=True, repr=False)
class AmbientOcclusion:
    """Occlusion of `ambient` and `environment` by strands and solids, computed on a grid."""

    cells: int = integer(40_000, low=1728, high=20_000_000, doc="approximate number of grid cells")
    directions: int = integer(32, low=2, high=1024, doc="directions of light")


@dataclass(frozen=True, slots=True, repr=False)
class Environment:
    """Light from a lat-long picture, which is not drawn; `ambient_occlusion` shades it."""

    image: str = file("picture", doc="lat-long picture (PNG, JPEG or Radiance .hdr) whose middle is at +z")
    intensity: float = number(1.0, low=0, doc="scale")
    rotation: float = number(0.0, unit="deg", doc="rotation about +y")
