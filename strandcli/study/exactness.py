"""The axis of references: solvers against exact solutions."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from ..errors import UsageError
from ..scene.model import Scene
from .axes import Axis, Request, chosen_solvers
from .motion.contestants import CONTESTANTS, Contestant, follow, prepare
from .motion.watch import least
from .points import Knobs, Point, grid
from .references import REFERENCES, Case, Track

FRAME = 1 / 24
"""Of the substeps of a reference, seconds: references have no film."""


class Exactness:
    """Runs of one reference."""

    def __init__(self, request: Request) -> None:
        if request.name not in REFERENCES:
            raise UsageError(f"no reference '{request.name}'; the references are {', '.join(REFERENCES)} and all")
        self.reference = REFERENCES[request.name]
        self.request = request
        self.metric, self.unit, self.title = self.reference.metric, self.reference.unit, self.reference.title
        self.absent: list[dict[str, str]] = []
        self.contestants: list[Contestant] = []
        for name in chosen_solvers(request):
            why = CONTESTANTS[name].lacks(self.reference.needs)
            if why:
                self.absent.append({"solver": name, "why": f"not represented: {why}"})
            else:
                self.contestants.append(CONTESTANTS[name])

    @property
    def references(self) -> int:
        """None is run: they are exact."""
        return 0

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """The exact quantities."""
        return {"name": self.reference.name, "exact": self.reference.exact()}

    def margins(self) -> Mapping[str, float]:
        """They are exact."""
        return {}

    def settings(self) -> list[dict[str, Any]]:
        """Steps, particles, and iterations where a solver has them."""
        request, reference = self.request, self.reference
        particles = request.particles if request.particles and len(reference.particles) > 1 else reference.particles
        out: list[dict[str, Any]] = []
        for one in self.contestants:
            steps = reference.steps.get(one.name, one.steps)
            if request.substeps:
                steps = tuple(FRAME / count for count in request.substeps)
            choices: dict[str, Any] = {"solver": (one.name,), "emitter.particles": particles}
            if one.iterations:  # a motion in small steps asks for few: the most will do
                usual = one.iterations[-1:] if reference.moving else one.iterations
                choices["rod.iterations"] = request.iterations or usual
            out += grid({**choices, "dt": request.steps or steps})
        return out

    def measure(self, knobs: Knobs) -> Point:
        """One run."""
        reference, contestant = self.reference, CONTESTANTS[knobs["solver"]]
        case = reference.case(knobs["emitter.particles"])
        scene = scene_of(case, contestant, knobs)

        def run() -> tuple[Track, float]:
            return follow(lambda: prepare(contestant, scene, case), knobs["dt"], reference.span, reference.moving)

        track, seconds = least(run)
        return Point(
            knobs=knobs,
            seconds=seconds,
            error=reference.measure(track),
            solver=contestant.name,
            sizes={"dt": knobs["dt"], "segment": 1 / (knobs["emitter.particles"] - 1)},
        )


def scene_of(case: Case, contestant: Contestant, knobs: Knobs) -> Scene:
    """The preset of a case as a solver is handed it."""
    from ..scene import loads
    from ..simulate.rules import registry

    data: dict[str, Any] = json.loads(json.dumps(case.settings))
    data["solver"] = contestant.scene_solver()
    for path, value in knobs.items():
        group, _, leaf = path.partition(".")
        if group == "rod":
            data[group][leaf] = value
    return loads(json.dumps(data), rules=registry(), name="reference")


AXIS = Axis(
    name="reference",
    doc="solvers against exact solutions",
    knobs=("solver", "dt", "emitter.particles", "rod.iterations"),
    metric="each reference's own",
    of_preset=False,
    open=Exactness,
)
