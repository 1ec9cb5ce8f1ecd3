"""A preset as a whole."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..fields import Colour, boolean, choice, colour, integer, items, model, number, optional, panels, rules, text
from .camera import LIGHTS, MOST_LIGHTS, AmbientOcclusion, Camera, DirectionalLight, Environment, Image, Light
from .emitter import Emitter
from .solids import SOLIDS, Solid
from .strands import Children, Curves, Detail, Material, Rod


@dataclass(frozen=True, slots=True, repr=False)
class Time:
    """The clock. Frame 1 is at time 0; frame f is at (f - 1) / fps."""

    frames: int = integer(
        48, low=0, high=1_000_000, doc="frames of the animation; 0: those of the strand file, 1 if it is still"
    )
    fps: float = number(24.0, low=0, high=100_000, unit="1/s", doc="frames per second; 0: the strand file's, else 24")
    substeps: int = integer(
        1, low=1, high=1000,
        doc="solver steps per frame; rods subdivide them for fast coils and swings",
    )  # fmt: skip
    jitter: float = number(
        0.0, low=0, high=0.9,
        doc="solver thesis: share by which steps are longer or shorter, as frames on a screen are; stiffness trembles",
    )  # fmt: skip
    preroll: float = number(
        0.0, low=0, high=3600, unit="s",
        doc="time simulated before frame 1, with keys clamped to the first one, or running if loop is true",
    )  # fmt: skip
    loop: bool = boolean(False, doc="keys and gusts repeat with the length of the animation, also during the pre-roll")

    @property
    def period(self) -> float:
        """Seconds after which all motion repeats; 0 where it does not."""
        return self.frames / self.fps if self.loop else 0.0

    def pose_time(self, time: float) -> float:
        """Where keys are read at a time in seconds: before frame 1 they stand still, unless the motion repeats."""
        return time % self.period if self.loop else max(time, 0.0)


@dataclass(frozen=True, slots=True, repr=False)
class RuleUse:
    """One entry of a preset's list of rules: a rule's registered name and its own validated parameters."""

    name: str
    parameters: Any
    path: str


@dataclass(frozen=True, slots=True, repr=False)
class Scene:
    """A whole preset. ``panels`` holds complete scenes, to be drawn side by side, and is empty for a single picture."""

    title: str = text("", doc="title of the picture")
    seed: int = integer(0, low=0, high=2**63 - 1, doc="seed of all random numbers")
    look: str = choice(
        "free",
        ("free", "source"),
        doc="source: as the thesis draws (z-buffer, Marschner's model, min/max shadow maps), and other settings "
        "are refused; free: any setting",
    )
    quality: str = choice(
        "preset",
        ("preset", "draft", "default", "best"),
        doc="drawing settings by name; those written beside it win; preset: none by name",
    )
    solver: str = choice(
        "thesis", ("thesis", "rod"), doc="thesis: the rules of the thesis; rod: inextensible rods with mass"
    )
    rod: Rod = model(Rod, doc="settings of `solver: rod`")
    time: Time = model(Time, doc="the clock")
    emitter: Emitter = model(Emitter, doc="where strands come from")
    children: Children | None = optional(
        Children, doc="strands drawn around the simulated ones; absent: only those are drawn"
    )
    rules: tuple[RuleUse, ...] = rules(
        (), doc="what moves the strands: a list is applied in its order, a mapping in the default order"
    )
    solids: tuple[Solid, ...] = items(SOLIDS, doc="objects that are drawn, cast shadows and stop strands")
    camera: Camera = model(Camera, doc="the point of view")
    image: Image = model(Image, doc="the picture")
    lights: tuple[Light, ...] = items(
        LIGHTS, default=(DirectionalLight(),), most=MOST_LIGHTS, doc="lights; an empty list is darkness"
    )
    ambient: Colour = colour((0.1, 0.1, 0.1), doc="uniform light from all directions")
    environment: Environment | None = optional(
        Environment, doc="light from a lat-long picture, added to `ambient`; absent: none"
    )
    ambient_occlusion: AmbientOcclusion | None = optional(
        AmbientOcclusion, doc="strands and solids occlude ambient and environment light; absent: they do not"
    )
    material: Material = model(Material, doc="how strands scatter light")
    curves: Curves = model(Curves, doc="smoothing")
    detail: Detail | None = optional(Detail, doc="level of detail; absent: all strands are drawn")
    label: str = text("", doc="caption of a panel")
    panels: tuple[Scene, ...] = panels((), doc="pictures side by side: this scene with some settings changed")
    source: str = field(default="", compare=False)
    sha256: str = field(default="", compare=False)

    @property
    def occluded(self) -> bool:
        """Whether ambient occlusion is asked for, and there is light for it to take away."""
        around = self.environment is not None and self.environment.intensity > 0
        return self.ambient_occlusion is not None and (around or any(self.ambient))

    @property
    def guided(self) -> bool:
        """Whether some strands of a file are simulated and the rest follow them. By the source's solver the emitter's
        motion alone carries a file's strands rigidly, and nothing is simulated."""
        if self.emitter.groom is None:
            return False
        return any(self.solver == "rod" or use.name != "emitter_motion" for use in self.rules)

    @property
    def drawn_strands(self) -> int:
        """Strands that are drawn when level of detail leaves none out."""
        if self.emitter.followers is not None:
            return self.emitter.followers.strands
        return self.emitter.strands * (1 if self.children is None else self.children.count)
