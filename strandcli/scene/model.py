"""What a person writes in a preset, as typed and frozen data.

Every class here mirrors one mapping of the YAML file. A field's default, unit, range and meaning stand together, and
the validator (`validate.py`), the JSON Schema (`schema.py`) and the documentation all read them from here.

Units: metres, seconds, degrees. Axes are right-handed with y up. A colour is three linear Rec. 709 numbers, or a
string "#rrggbb" which is read as sRGB.
"""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

from . import fields
from .fields import (
    Colour,
    Vector,
    boolean,
    choice,
    colour,
    integer,
    items,
    model,
    names,
    number,
    optional,
    panels,
    rules,
    size,
    text,
    union,
    vector,
    window,
)
from .style import Children


@dataclass(frozen=True, slots=True, repr=False)
class Time:
    """The clock. Frame 1 is at time 0; frame f is at (f - 1) / fps."""

    frames: int = integer(48, low=1, high=1_000_000, doc="frames in the whole animation")
    fps: float = number(24.0, above=0, high=100_000, unit="1/s", doc="frames a second")
    substeps: int = integer(1, low=1, high=1000, doc="solver steps a frame; the step is 1 / (fps * substeps)")
    preroll: float = number(
        0.0, low=0, high=3600, unit="s", doc="time simulated before frame 1, with everything held at its first key"
    )


@dataclass(frozen=True, slots=True, repr=False)
class PoseKey:
    """A position and an orientation at one moment."""

    time: float = number(0.0, unit="s", doc="when; frame 1 is at 0")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="translation")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z; may exceed 360")
    ease: str = choice("smooth", ("smooth", "linear", "step"), doc="how this key is left for the next one")


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


@dataclass(frozen=True, slots=True, repr=False)
class Emitter:
    """Where strands grow, how many and how long, and how the whole of it moves (thesis §1)."""

    shape: SphereShape | DiscShape | PlaneShape = union(
        SphereShape(),
        {"sphere": SphereShape, "disc": DiscShape, "plane": PlaneShape},
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
    jitter: float = number(0.0, low=0, high=180, unit="deg", doc="cone within which each strand's direction is tilted")
    curl_angle: float = number(
        25.0, low=0, high=80, unit="deg", doc="angle of a curled strand to its own axis; only with curl_turns"
    )
    curl_turns: float = number(0.0, low=0, high=1000, doc="turns of a helix from root to tip; 0: straight")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="where it stands when it has no keys")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="how it stands when it has no keys")
    keys: tuple[PoseKey, ...] = items(PoseKey, doc="motion; roots and directions turn with it")

    @property
    def segment(self) -> float:
        """The longest distance between two particles of a strand, metres."""
        return self.length * (1 + self.length_variation) / (self.particles - 1)


@dataclass(frozen=True, slots=True, repr=False)
class SphereSolid:
    """A ball."""

    kind: str = choice("sphere", ("sphere",))
    name: str = text("", doc="name for a collision rule's `with`")
    radius: float = number(1.0, above=0, unit="m", doc="radius")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="centre")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z")
    keys: tuple[PoseKey, ...] = items(PoseKey, doc="motion, in place of position and rotation")
    follow: str = choice("none", ("none", "emitter"), doc="emitter: the pose is taken in the emitter's frame")
    colour: Colour = colour((0.18, 0.18, 0.18), doc="diffuse colour")
    visible: bool = boolean(True, doc="drawn, and casting shadows; collisions do not ask")


@dataclass(frozen=True, slots=True, repr=False)
class CapsuleSolid:
    """A rounded cylinder along its own y axis."""

    kind: str = choice("capsule", ("capsule",))
    name: str = text("", doc="name for a collision rule's `with`")
    radius: float = number(1.0, above=0, unit="m", doc="radius")
    length: float = number(1.0, low=0, unit="m", doc="distance between the centres of its two round ends")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="centre")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z")
    keys: tuple[PoseKey, ...] = items(PoseKey, doc="motion, in place of position and rotation")
    follow: str = choice("none", ("none", "emitter"), doc="emitter: the pose is taken in the emitter's frame")
    colour: Colour = colour((0.18, 0.18, 0.18), doc="diffuse colour")
    visible: bool = boolean(True, doc="drawn, and casting shadows; collisions do not ask")


@dataclass(frozen=True, slots=True, repr=False)
class PlaneSolid:
    """Everything below a plane through `position`, whose normal is its own +y axis: a ground."""

    kind: str = choice("plane", ("plane",))
    name: str = text("", doc="name for a collision rule's `with`")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="a point of the plane")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z")
    keys: tuple[PoseKey, ...] = items(PoseKey, doc="motion, in place of position and rotation")
    follow: str = choice("none", ("none", "emitter"), doc="emitter: the pose is taken in the emitter's frame")
    colour: Colour = colour((0.18, 0.18, 0.18), doc="diffuse colour")
    fade: float = number(
        0.0, low=0, unit="m", doc="distance from `position` over which it fades into the background; 0: never"
    )
    visible: bool = boolean(True, doc="drawn, and casting shadows; collisions do not ask")


@dataclass(frozen=True, slots=True, repr=False)
class BoxSolid:
    """A cuboid."""

    kind: str = choice("box", ("box",))
    name: str = text("", doc="name for a collision rule's `with`")
    size: Vector = vector((1.0, 1.0, 1.0), above=0, unit="m", doc="whole extents along its own axes")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="centre")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z")
    keys: tuple[PoseKey, ...] = items(PoseKey, doc="motion, in place of position and rotation")
    follow: str = choice("none", ("none", "emitter"), doc="emitter: the pose is taken in the emitter's frame")
    colour: Colour = colour((0.18, 0.18, 0.18), doc="diffuse colour")
    visible: bool = boolean(True, doc="drawn, and casting shadows; collisions do not ask")


Solid = SphereSolid | CapsuleSolid | PlaneSolid | BoxSolid
SOLIDS = {"sphere": SphereSolid, "capsule": CapsuleSolid, "plane": PlaneSolid, "box": BoxSolid}


@dataclass(frozen=True, slots=True, repr=False)
class CameraKey:
    """The camera at one moment. What is left out is taken from the camera itself."""

    time: float = number(0.0, unit="s", doc="when; frame 1 is at 0")
    position: Vector | None = vector(None, unit="m", doc="eye")
    target: Vector | None = vector(None, unit="m", doc="point looked at")
    fov: float | None = number(None, above=0, below=180, unit="deg", doc="vertical field of view (perspective)")
    height: float | None = number(None, above=0, unit="m", doc="height of the view (orthographic)")
    ease: str = choice("smooth", ("smooth", "linear", "step"), doc="how this key is left for the next one")


@dataclass(frozen=True, slots=True, repr=False)
class Camera:
    """The point of view."""

    kind: str = choice("perspective", ("perspective", "orthographic"), doc="projection")
    position: Vector = vector((0.0, 0.0, 5.0), unit="m", doc="eye")
    target: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="point looked at")
    up: Vector = vector((0.0, 1.0, 0.0), unit="1", nonzero=True, doc="direction that is up in the picture")
    fov: float = number(40.0, above=0, below=180, unit="deg", doc="vertical field of view (perspective)")
    height: float = number(3.0, above=0, unit="m", doc="height of the view (orthographic)")
    near: float = number(0.01, above=0, unit="m", doc="nothing nearer than this is drawn")
    aperture: float = number(
        0.0, low=0, high=1000, unit="m", doc="diameter of the lens (perspective); 0: a pinhole, sharp everywhere"
    )
    focus: float | None = number(None, above=0, unit="m", doc="depth that is sharp; absent: that of the target")
    shutter: float = number(
        0.0, low=0, high=1, doc="share of a frame that the shutter is open, up to the frame's own time; 0.5 is usual"
    )
    samples: int = integer(
        16, low=1, high=4096, doc="pictures that are averaged over lens and shutter, where either is open"
    )
    keys: tuple[CameraKey, ...] = items(CameraKey, doc="motion")


AOVS = ("depth", "mask", "tangent", "orientation", "strand_id", "shadow", "linear")
"""Layers beside the picture; what each holds is told in `strandcli.draw.aovs`."""


@dataclass(frozen=True, slots=True, repr=False)
class Image:
    """The picture."""

    size: tuple[int, int] = size((800, 600), high=32_768, unit="px", doc='width and height, as [w, h] or "800x600"')
    supersample: int = integer(1, low=1, high=8, doc="samples along each side of a pixel")
    background: Colour = colour((0.03, 0.035, 0.045), doc="behind everything; with horizon, at the top")
    horizon: Colour | None = colour(None, doc="background at the bottom; absent: one colour everywhere")
    exposure: float = number(0.0, low=-20, high=20, unit="stops", doc="light is scaled by 2 ** exposure")
    resolver: str = choice(
        "zbuffer",
        ("zbuffer", "sorted", "kbuffer"),
        doc="which strands a pixel shows. zbuffer: the nearest, as a hard line; sorted: all, each by what it covers of "
        "the pixel, in the order of depth; kbuffer: the same with a bound on the fragments of a pixel",
    )
    nearest: int = integer(
        8, low=1, high=64, doc="fragments that a pixel holds (kbuffer); the last one stands for all that are behind"
    )
    tone: str = choice(
        "srgb", ("srgb", "filmic"), doc="srgb: light beyond 1 is cut off; filmic: it rolls off, mid grey stays"
    )
    crop: tuple[int, int, int, int] | None = window(
        high=32_768, doc="part that is drawn: x, y, width, height; absent: all of it"
    )
    aovs: tuple[str, ...] = names(doc=f"layers written beside each picture, of {', '.join(AOVS)}")

    @property
    def drawn(self) -> tuple[int, int]:
        """Width and height of what is drawn: of the crop window, where there is one."""
        return self.size if self.crop is None else self.crop[2:]


@dataclass(frozen=True, slots=True, repr=False)
class Shadow:
    """The strands' shadow map of one light: the source's (thesis §3, corrected) or a deep opacity map."""

    model: str = choice(
        "minmax",
        ("minmax", "opacity", "off"),
        doc="minmax: nearest and farthest strand a texel; opacity: layers that count strands; off: built for nobody",
    )
    size: int = integer(512, low=1, high=8192, unit="texels", doc="texels along a side; of opacity, at most")
    layers: int = integer(13, low=1, high=61, doc="layers of opacity")
    texel: float | None = number(
        None, above=0, unit="m", doc="side of a texel of opacity; absent: from the distance between strands"
    )
    bias: float = number(0.0, low=0, unit="m", doc="depth in front of which nothing is shaded")


@dataclass(frozen=True, slots=True, repr=False)
class DirectionalLight:
    """Light from infinitely far, like the sun."""

    kind: str = choice("directional", ("directional",))
    direction: Vector = vector((-0.5, -1.0, -0.5), unit="1", nonzero=True, doc="where the light travels to")
    colour: Colour = colour((1.0, 1.0, 1.0), doc="colour")
    intensity: float = number(3.0, low=0, doc="irradiance on a surface that faces it")
    shadow: Shadow = model(Shadow, doc="the strands' shadow map")


@dataclass(frozen=True, slots=True, repr=False)
class PointLight:
    """Light from a point, falling off with the square of the distance."""

    kind: str = choice("point", ("point",))
    position: Vector = vector((3.0, 3.0, 3.0), unit="m", doc="where it is")
    colour: Colour = colour((1.0, 1.0, 1.0), doc="colour")
    intensity: float = number(30.0, low=0, unit="W/sr", doc="irradiance at one metre")
    shadow: Shadow = model(Shadow, doc="the strands' shadow map")


Light = DirectionalLight | PointLight


@dataclass(frozen=True, slots=True, repr=False)
class Environment:
    """Light from all round, from a lat-long picture; it is not drawn, and nothing casts a shadow in it."""

    image: str = text("", doc="picture, beside the preset: PNG (taken as sRGB) or Radiance .hdr; its middle is at +z")
    intensity: float = number(1.0, low=0, doc="scale")
    rotation: float = number(0.0, unit="deg", doc="turn about +y")


LIGHTS = {"directional": DirectionalLight, "point": PointLight}

PIGMENTS = (
    "rgb", "black", "dark_brown", "brown", "light_brown", "auburn", "red", "dark_blond", "blond", "platinum", "white",
)  # fmt: skip


@dataclass(frozen=True, slots=True, repr=False)
class Material:
    """How strands take light: Marschner et al. 2003 (R, TT and TRT lobes) or Chiang et al. 2016 (those and the rest,
    energy conserving), and an approximation of the light that goes from strand to strand, which both leave out."""

    model: str = choice(
        "marschner",
        ("marschner", "chiang"),
        doc="marschner: alpha, beta, azimuthal; chiang, the model of path tracers: tilt, beta_m, beta_n",
    )
    colour: Colour = colour((0.22, 0.11, 0.05), doc="colour of a mass of such strands, where pigment is rgb")
    # inside this class `colour` is by now the field above
    tip_colour: Colour | None = fields.colour(None, doc="colour at the tip; absent: the same along the strand")
    pigment: str = choice("rgb", PIGMENTS, doc="rgb: as `colour`; or hair of a natural colour, made by melanin")
    eumelanin: float | None = number(
        None, low=0, high=50, doc="black-brown melanin, 1 is brown; with pheomelanin in place of a pigment's own"
    )
    pheomelanin: float | None = number(None, low=0, high=50, doc="red-yellow melanin")
    grey: float = number(0.0, low=0, high=1, doc="share of strands without any pigment")
    colour_variation: float = number(0.0, low=0, high=1, doc="spread of brightness from strand to strand")
    eta: float = number(1.55, above=1, high=3, doc="index of refraction")
    alpha: float = number(-7.5, low=-20, high=20, unit="deg", doc="shift of the R lobe toward the root, by the scales")
    beta: float = number(7.5, low=0.1, high=45, unit="deg", doc="longitudinal width of the R lobe (standard deviation)")
    azimuthal: float = number(12.0, low=1, high=60, unit="deg", doc="azimuthal roughness (standard deviation)")
    tilt: float = number(2.5, low=-10, high=10, unit="deg", doc="angle at which the scales stand up (chiang)")
    beta_m: float = number(0.25, low=0.001, high=1, doc="longitudinal roughness (chiang)")
    beta_n: float = number(0.3, low=0.001, high=1, doc="azimuthal roughness (chiang)")
    specular: float = number(1.0, low=0, high=10, doc="scale of the lobes together; 0 leaves their tables out")
    scatter: str = choice(
        "diffuse",
        ("diffuse", "dual"),
        doc="light from strand to strand: a diffuse stand-in; or dual scattering, under lights whose shadow.model is "
        "opacity, with Chiang's lobes",
    )
    diffuse: float = number(0.35, low=0, high=10, doc="scale of the diffuse stand-in; 0 leaves it out")
    width: float = number(
        0.0,
        low=0,
        unit="m",
        doc="strand diameter near the root; with the zbuffer drawn only where it exceeds a pixel. 0: lines one pixel "
        "wide",
    )
    taper: float = number(0.7, low=0, high=1, doc="part of the width that is lost from root to tip")
    opacity: float = number(
        1.0, low=0, high=1, doc="share of the light from behind that a strand stops where it covers (sorted, kbuffer)"
    )


@dataclass(frozen=True, slots=True, repr=False)
class Curves:
    """How a chain of particles becomes a smooth line (thesis §3)."""

    mode: str = choice(
        "adaptive",
        ("adaptive", "fixed", "off"),
        doc="adaptive: pieces by screen error; fixed: 2 ** level; off: straight",
    )
    level: int = integer(2, low=0, high=8, doc="each segment becomes 2 ** level pieces (fixed), at most (adaptive)")
    tolerance: float = number(0.25, above=0, unit="px", doc="greatest distance of a piece from its curve (adaptive)")
    tangents: str = choice(
        "difference",
        ("difference", "printed"),
        doc="central difference, or the source's cross products with its artefact",
    )


@dataclass(frozen=True, slots=True, repr=False)
class Detail:
    """Level of detail: far away fewer strands are drawn, each one wider by the inverse of the fraction kept."""

    near: float = number(10.0, above=0, unit="m", doc="nearer than this every strand is drawn")
    fraction: float = number(0.1, above=0, high=1, doc="smallest fraction kept, however far")
    widen: bool = boolean(True, doc="widen by 1 / fraction, so that the covered area stays")


@dataclass(frozen=True, slots=True, repr=False)
class Rod:
    """The strands' matter and how the solver `rod` moves them. Twist is not represented.

    A material by name gives density, radius and Young's modulus; a number written beside it replaces its own.
    """

    ABSENT: ClassVar[dict[str, str]] = {
        "twist": "twist is not represented: rods bend and do not resist torsion; curls are held by rest: shape",
        "torsion": "twist is not represented: rods bend and do not resist torsion; curls are held by rest: shape",
        "mass": "mass follows from density and radius; write those",
        "stiffness": "bending stiffness follows from young and radius; write those",
        "stretch": "rods do not stretch",
    }

    material: str = choice(
        "hair", ("hair", "wool", "grass", "wire"), doc="hair, wool: keratin fibres; grass: a blade; wire: thin steel"
    )
    density: float | None = number(None, above=0, unit="kg/m³", doc="mass a volume; absent: the material's")
    radius: float | None = number(None, above=0, unit="m", doc="radius at the root; absent: the material's")
    young: float | None = number(None, above=0, high=1e13, unit="Pa", doc="Young's modulus; absent: the material's")
    tip: float = number(1.0, low=0.05, high=1, doc="radius at the tip over that at the root")
    rest: str = choice(
        "shape",
        ("straight", "shape", "sag_free"),
        doc="unbent form: straight; as emitted, curls included; or such that the emitted form hangs still "
        "under gravity",
    )
    drag: float = number(1.0, low=0, high=1e6, unit="1/s", doc="rate at which strands take on the velocity of the air")
    damping: float = number(0.001, low=0, high=1e3, unit="s", doc="inner damping: bending moment a rate of bending")
    friction: float = number(0.3, low=0, high=10, doc="Coulomb's coefficient against solids")
    integrator: str = choice(
        "euler", ("euler", "bdf2"), doc="euler: first order, calms motion down; bdf2: second order, keeps it up"
    )
    iterations: int = integer(200, low=1, high=1000, doc="Newton iterations a step at the most; two are usual")
    precision: str = choice(
        "single", ("single", "double"), doc="of the solver's numbers; beyond 20 segments it is double in any case"
    )


@dataclass(frozen=True, slots=True, repr=False)
class RuleUse:
    """One entry of a preset's list of rules: a rule's registered name and its own validated parameters."""

    name: str
    parameters: Any
    path: str


@dataclass(frozen=True, slots=True, repr=False)
class Scene:
    """A whole preset. ``panels`` holds complete scenes, to be drawn side by side, and is empty for a single picture."""

    title: str = text("", doc="what there is to see")
    seed: int = integer(0, low=0, high=2**63 - 1, doc="seed of everything random")
    look: str = choice(
        "free",
        ("free", "source"),
        doc="source: as the source draws, by the z-buffer, Marschner's model and min/max shadow maps; a setting that "
        "says otherwise is refused. free: each setting by itself",
    )
    quality: str = choice(
        "preset",
        ("preset", "draft", "default", "best"),
        doc="settings of drawing by name, where they are not written beside it; preset: as the rest says",
    )
    solver: str = choice(
        "thesis", ("thesis", "rod"), doc="how strands move: the source's rules, or inextensible rods with mass"
    )
    rod: Rod = model(Rod, doc="matter and settings of the solver rod")
    time: Time = model(Time, doc="the clock")
    emitter: Emitter = model(Emitter, doc="where strands come from")
    children: Children | None = optional(
        Children, doc="strands drawn about the simulated ones, in locks and waves; absent: those alone are drawn"
    )
    rules: tuple[RuleUse, ...] = rules(
        doc="what moves the strands: a list is applied in its own order, a mapping in the documented default order"
    )
    solids: tuple[Solid, ...] = items(SOLIDS, doc="things that are drawn, hide, cast shadows and can be collided with")
    camera: Camera = model(Camera, doc="the point of view")
    image: Image = model(Image, doc="the picture")
    lights: tuple[Light, ...] = items(LIGHTS, default=(DirectionalLight(),), doc="lights; an empty list is darkness")
    ambient: Colour = colour((0.1, 0.1, 0.1), doc="light from everywhere")
    environment: Environment | None = optional(
        Environment, doc="light from all round by a picture, added to `ambient`; absent: none"
    )
    material: Material = model(Material, doc="how strands take light")
    curves: Curves = model(Curves, doc="smoothing")
    detail: Detail | None = optional(Detail, doc="level of detail; absent: every strand is drawn")
    label: str = text("", doc="what stands below the picture when it is a panel")
    panels: tuple[Scene, ...] = panels(doc="pictures side by side: each is this scene with a few settings changed")
    source: str = field(default="", compare=False)
    sha256: str = field(default="", compare=False)

    @property
    def drawn_strands(self) -> int:
        """Strands that are drawn when level of detail leaves none out."""
        return self.emitter.strands * (1 if self.children is None else self.children.count)
