"""A preset as a whole."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..fields import Colour, boolean, choice, colour, integer, items, model, number, optional, panels, rules, text
from .camera import Camera, Image
from .emitter import Emitter
from .lights import LIGHTS, MOST_LIGHTS, AmbientOcclusion, DirectionalLight, Environment, Light
from .rod import Rod
from .solids import SOLIDS, Solid
from .strands import Curves, Detail, Material
from .style import Children


@dataclass(frozen=True, slots=True, repr=False)
class Time:
    """The clock. Frame 1 is at time 0; frame f is at (f - 1) / fps."""

    frames: int = integer(
        48,
        low=0,
        high=1_000_000,
        doc="frames in the whole animation; 0: all that the file of strands has, 1 if it is still",
    )
    fps: float = number(
        24.0, low=0, high=100_000, unit="1/s", doc="frames a second; 0: those that the file of strands says, else 24"
    )
    substeps: int = integer(
        1, low=1, high=1000,
        doc="solver steps a frame; the step is 1 / (fps * substeps), which rods cut where coils or swings ask for it",
    )  # fmt: skip
    preroll: float = number(
        0.0, low=0, high=3600, unit="s",
        doc="time simulated before frame 1, with everything held at its first key, or with loop: true in motion",
    )  # fmt: skip
    loop: bool = boolean(
        False, doc="all frames repeat without end: keys and gusts have that period, also during the pre-roll"
    )

    @property
    def period(self) -> float:
        """Seconds after which all motion repeats; 0 where it does not."""
        return self.frames / self.fps if self.loop else 0.0

    def pose_time(self, time: float) -> float:
        """Where keys are read at a time in seconds: before frame 1 they are held, unless the motion repeats."""
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
        doc="what moves the strands: a list is applied in its own order, a rule as often as it is listed; a mapping in "
        "the documented default order"
    )
    solids: tuple[Solid, ...] = items(SOLIDS, doc="things that are drawn, hide, cast shadows and can be collided with")
    camera: Camera = model(Camera, doc="the point of view")
    image: Image = model(Image, doc="the picture")
    lights: tuple[Light, ...] = items(
        LIGHTS, default=(DirectionalLight(),), most=MOST_LIGHTS, doc="lights; an empty list is darkness"
    )
    ambient: Colour = colour((0.1, 0.1, 0.1), doc="light from everywhere")
    environment: Environment | None = optional(
        Environment, doc="light from all round by a picture, added to `ambient`; absent: none"
    )
    ambient_occlusion: AmbientOcclusion | None = optional(
        AmbientOcclusion,
        doc="ambient and environment reach what strands and solids leave open; absent: they reach everything",
    )
    material: Material = model(Material, doc="how strands take light")
    curves: Curves = model(Curves, doc="smoothing")
    detail: Detail | None = optional(Detail, doc="level of detail; absent: every strand is drawn")
    label: str = text("", doc="what stands below the picture when it is a panel")
    panels: tuple[Scene, ...] = panels(doc="pictures side by side: each is this scene with a few settings changed")
    source: str = field(default="", compare=False)
    sha256: str = field(default="", compare=False)

    @property
    def occluded(self) -> bool:
        """Whether ambient occlusion is asked for, and there is light for it to take away."""
        around = self.environment is not None and self.environment.intensity > 0
        return self.ambient_occlusion is not None and (around or any(self.ambient))

    @property
    def guided(self) -> bool:
        """Whether some strands of a file are simulated and the others follow them. By the source's solver the emitter's
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
