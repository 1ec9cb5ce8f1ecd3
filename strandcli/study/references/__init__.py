"""The axis of references: rods against exact solutions, at rest and in motion."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from ...errors import UsageError
from ...scene.model import Rod, Scene
from ...simulate.rod.solver import RodSolver
from ..motion import follow, least
from ..points import Parameters, Point, grid
from ..sweep import Experiment, Request, chosen_solvers
from . import elastica, incline, layer, oscillation, spring, tuft
from .base import Case, Reference, Track

REFERENCES: Mapping[str, Reference] = {
    one.name: one
    for one in (
        elastica.ELASTICA, oscillation.BEAM, oscillation.SWING, spring.SPRING, incline.INCLINE, layer.LAYER,
        tuft.TUFT,
    )
}  # fmt: skip
"""By name, in the order in which `--reference all` goes through them."""
FRAME = 1 / 24
"""Of the substeps of a reference, seconds: references have no film."""
ITERATIONS = (2, Rod().iterations)
"""To try, where nothing moves fast."""


class References(Experiment):
    """Runs of one reference. All of them ask for mass and rigidity in physical units, which the solver thesis lacks."""

    axis = "reference"

    def __init__(self, request: Request) -> None:
        if request.name not in REFERENCES:
            raise UsageError(f"no reference '{request.name}'; the references are {', '.join(REFERENCES)} and all")
        self.reference = one = REFERENCES[request.name]
        self.request = request
        self.metric, self.unit, self.title = one.metric, one.unit, one.title
        self.solvers = chosen_solvers(request)
        self.absent = [
            {"solver": name, "why": f"not represented: {one.needs}"} for name in self.solvers if name != "rod"
        ]

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """The exact quantities."""
        return {"name": self.reference.name, "exact": self.reference.exact()}

    def settings(self) -> list[dict[str, Any]]:
        """Steps, particles and iterations."""
        request, reference = self.request, self.reference
        if "rod" not in self.solvers:
            return []
        steps = request.steps or reference.steps
        if request.substeps:
            steps = tuple(FRAME / count for count in request.substeps)
        # a motion in small steps asks for few iterations: the most will do
        usual = ITERATIONS[-1:] if reference.moving else ITERATIONS
        return grid({
            "solver": ("rod",), "emitter.particles": request.particles or reference.particles,
            "rod.iterations": request.iterations or usual, "dt": steps,
        })  # fmt: skip

    def measure(self, parameters: Parameters) -> Point:
        """One run."""
        reference = self.reference
        case = reference.case(parameters["emitter.particles"])
        scene = scene_of(case, parameters)

        def run() -> tuple[Track, float]:
            times, positions, seconds = follow(
                lambda: solver_for(scene, case), parameters["dt"], reference.span, reference.moving
            )
            return Track(times, positions), seconds

        track, seconds = least(run)
        sizes = {"dt": parameters["dt"], "segment": 1 / (parameters["emitter.particles"] - 1)}
        return Point(parameters, seconds, reference.measure(track), "rod", sizes)


def scene_of(case: Case, parameters: Parameters) -> Scene:
    """The preset of a case as rods are handed it."""
    from ...scene import loads
    from ...simulate.rules import registry

    data: dict[str, Any] = json.loads(json.dumps(case.settings))
    data["solver"] = "rod"
    if "rod.iterations" in parameters:
        data["rod"]["iterations"] = parameters["rod.iterations"]
    return loads(json.dumps(data), rules=registry(), name="reference")


def solver_for(scene: Scene, case: Case) -> RodSolver:
    """The solver of a case's scene, its extra conditions set."""
    solver = RodSolver(scene, case.groom)
    if case.tip_mass:
        # masses are stored relative to a segment's, of which a strand has as many as it has particles but the root
        solver.weight_tip(case.tip_mass * (scene.emitter.particles - 1))
    return solver


def track_of(case: Case, dt: float, span: float, moving: bool = False) -> Track:
    """A run of a case in steps of ``dt`` seconds."""
    scene = scene_of(case, {})
    return Track(*follow(lambda: solver_for(scene, case), dt, span, moving)[:2])
