"""Thin strands that are thrown at each other with the rule `contact`: whether one passes through another.

A strand of 0.25 m is thrown at others in steps in which it goes many times its thickness, up to its own length and
more. With free tips it may go round a tip, so that nothing but its ways tells; with pinned tips strands are closed to
curves far away from each other, whose linking number must stay what it was, whatever their ways.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.model import Emitter, Rod, RuleUse, Scene, Time
from ...simulate import solver_of
from ...simulate.rod.kernels.arrays import PACK
from ...simulate.rules import registry
from .crossing import Floats, Passing, linking
from .drive import Meter
from .scenes import Started
from .strand import Metrics, only

LENGTH = 0.25
ABOVE, BOW = 0.3, 0.1
"""Of a length: how far the strand that is thrown is above the others, and the ends of one in a bow."""
AFTER = 8
"""Steps after those in which it would meet them."""
FAR = 40.0
"""Where curves are closed, in lengths."""
ANGLES = {"across": 90.0, "askew": 45.0, "along": 10.0}
"""Between a strand and the one that it is thrown at, degrees; the flatter, the further does it slide along it."""
KINDS = (*ANGLES, "bundle", "looped")
"""``bundle``: across four others; ``looped``: both pinned at both ends, one in a bow over the other."""
SPEED = {"2": 2.0, "10": 10.0, "50": 50.0, "200": 200.0}
"""Of the tip or the middle, m/s."""
RATE = {"24Hz": 24.0, "60Hz": 60.0, "240Hz": 240.0}
THICKNESS = {"0.2mm": 2e-4, "1mm": 1e-3, "5mm": 5e-3}
AXES: dict[str, tuple[str, ...]] = {
    "of": KINDS, "speed": tuple(SPEED), "dt": tuple(RATE), "thickness": tuple(THICKNESS),
}  # fmt: skip
REST = {
    "n": ("10", "5", "20"),
    "friction": ("0.3", "0", "1"),
    "young": ("1e9", "1e6", "1e12"),
    "twist": ("none", "coil"),
}
"""Axes of which each scene has one value, each in its turn."""
RADIUS = 5e-5
COIL = 0.5
"""Radians by which edges of coils turn from one to the next."""


def thrown(labels: dict[str, str]) -> tuple[Scene, Started]:
    """The scene of a throw, without its velocities: the last strand is the one that is thrown."""
    n, kind, twist = int(labels["n"]), labels["of"], labels["twist"]
    end = "pinned" if kind == "looped" else "free"
    rest: Any = "shape" if kind == "looped" or twist == "coil" else "straight"
    rod = Rod(
        radius=RADIUS, density=1300.0, young=float(labels["young"]), rest=rest, drag=0.0, damping=0.0,
        end=end,
    )  # fmt: skip
    touching = registry()["contact"].Parameters(
        thickness=THICKNESS[labels["thickness"]], friction=float(labels["friction"])
    )
    calm = registry()["gravity"].Parameters(acceleration=(0.0, 0.0, 0.0))
    groom = _groom(kind, twist, n)
    return Scene(
        solver="rod", rod=rod, time=Time(fps=RATE[labels["dt"]], frames=1000),
        emitter=Emitter(strands=len(groom.roots), particles=n + 1, length=LENGTH),
        rules=(RuleUse("gravity", calm, "gravity"), RuleUse("contact", touching, "contact")),
    ), groom  # fmt: skip


def _groom(kind: str, twist: str, n: int) -> Started:
    """Strands along x about the origin, and above them the one that is thrown, along z or at an angle."""
    angle = np.radians(ANGLES.get(kind, 90.0))
    way = np.array([np.cos(angle), 0.0, np.sin(angle)])
    count = 4 if kind == "bundle" else 1
    roots = np.array([[-0.5, 0.0, 0.08 * (i - (count - 1) / 2)] for i in range(count)])
    edges = np.tile([1.0, 0.0, 0.0], (count + 1, n, 1))
    edges[-1] = way
    if kind == "looped":
        # with both its ends held it can be thrown to the other side
        lift = np.linspace(1.0, -1.0, n)
        edges[-1] = np.stack([np.zeros(n), np.sin(lift), np.cos(lift)], 1)
        edges[-1] /= np.linalg.norm(edges[-1], axis=1, keepdims=True)
    if twist == "coil":
        turn = COIL * np.arange(1, n + 1)
        edges[:-1] += 0.4 * np.stack([np.zeros(n), np.sin(turn), np.cos(turn) - 1], 1)
        edges /= np.linalg.norm(edges, axis=2, keepdims=True)
    span = edges[-1].mean(0) if kind == "looped" else way
    roots = np.vstack([roots, -0.5 * span + (0.0, BOW if kind == "looped" else ABOVE, 0.0)]) * LENGTH
    total = len(roots)
    return Started(
        roots.astype(np.float32), edges[:, 0].astype(np.float32), np.full(total, LENGTH, np.float32),
        np.zeros(total, np.float32), edges=edges,
    )  # fmt: skip


def throw(solver: Any, kind: str, speed: float) -> None:
    """Give the last strand a velocity down: of its tip as it turns about its root, or of its middle."""
    for one in (solver.state.velocity, solver.state.before, solver.state.ahead):
        rows = one.reshape(len(one), -1, 3, PACK)
        share = np.linspace(0, 1, rows.shape[1] + 1)[1:]
        rows[0, :, 1, solver.strands - 1] = -speed * (np.sin(np.pi * share) if kind == "looped" else share)


def closed(strand: NDArray[np.floating], side: float) -> Floats:
    """A strand (N + 1, 3) as a closed curve: from its ends far up or down."""
    x = np.asarray(strand, np.float64)
    away = np.array([0.0, side * FAR * LENGTH, 0.0])
    return np.vstack([x, x[-1] + away, x[0] + away])


def check_tunnelling(solver: str, *, labels: dict[str, str]) -> Metrics:
    """How many segments pass through each other, and by how much a linking number changes."""
    only(solver, "rod", "it does not have the rule contact")
    scene, groom = thrown(labels)
    kind, dt, speed = labels["of"], 1 / RATE[labels["dt"]], SPEED[labels["speed"]]
    one: Any = solver_of(scene)(scene, groom)
    meter = Meter(scene, groom.lengths.astype(np.float64) / (scene.emitter.particles - 1), LENGTH, touching=False)
    throw(one, kind, speed)
    passing = Passing(one)
    steps = int(np.ceil(1.5 * ABOVE * LENGTH / (speed * dt))) + AFTER
    begin = _links(one.particles()) if kind == "looped" else 0.0
    with np.errstate(all="ignore"):
        meter.follow(one, dt * np.arange(1.0, steps + 1))
    found = {**meter.metrics(slice(None)), "passed": passing.count(), "closeness": _closeness(one)}
    if kind == "looped":
        found["linking_changed"] = abs(_links(one.particles()) - begin)
    return found


def _closeness(one: Any) -> float:
    return float(one.contact.penetration / one.contact.thickness)


def _links(x: NDArray[np.floating]) -> float:
    """Linking numbers, rounded, of every two strands; the last is closed from above and all others from below."""
    curves = [closed(strand, 1.0 if s == len(x) - 1 else -1.0) for s, strand in enumerate(x)]
    return float(sum(abs(round(linking(a, b))) for a, b in combinations(curves, 2)))


def rows() -> list[dict[str, str]]:
    """Every combination of what is thrown how fast, thin and finely, with the rest in turns."""
    found = []
    for number, labels in enumerate(product(*AXES.values())):
        row = dict(zip(AXES, labels, strict=True))
        for place, (axis, values) in enumerate(REST.items()):
            row[axis] = values[(number // (1, 5, 7, 3)[place] + place) % len(values)]
        found.append(row)
    return found


def _name(row: dict[str, str]) -> str:
    given = (f"{axis}={label}" for axis, label in row.items() if axis in AXES or label != REST[axis][0])
    return "/".join(("check=tunnelling", *given))


CHECKS: dict[str, Callable[[str], Metrics]] = {_name(row): partial(check_tunnelling, labels=row) for row in rows()}
QUICK = tuple(name for name in CHECKS if "/speed=200/dt=24Hz/thickness=0.2mm" in name)
