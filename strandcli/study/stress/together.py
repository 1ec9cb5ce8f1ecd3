"""The matrix of rods once more, with strands that interact or twist in every case (`strandcli stress --with`).

Each scene of the matrix meets several of the combinations of what strands do to each other and how they twist, chosen
by its name, so that every value of every axis meets every combination. A scene's one strand becomes a few. What the
product refuses for a clash of settings is no combination; that it does is what `traits` looks at.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...scene.faults import shown
from ...scene.model import Rod, RuleUse, Scene
from ...simulate.rules import registry
from . import sheets
from .axes import Case, case_named
from .crossing import Passing
from .drive import followed
from .scenes import Started, groom_of, scene_of, times_of
from .task import Task
from .verdicts import Verdict, judge, told_of

KINDS = ("interaction", "twist")
STRANDS = "4"
"""In place of one: contact is dear, and of few strands it is as hard."""
MOST_TOUCHING = 4
"""Strands that contact is tried with at the most."""
SELDOM, TOUCHING = 256, 10
"""Of how many cases one is tried with contact, beside those that are pairs of all axes; of the small matrix."""
SHARE = {False: 2, True: 4}
"""By how much runs are shorter than the matrix's, with the grid and with contact."""
CLOSE = 0.05
"""By how much roots are brought together where no solid is in their way: strands meet."""
RADIUS = 0.02
"""In L: the matrix has strands of 2 L, which no cell could be smaller than."""
GRID = {
    "grid": {"density": 10.0, "cell": 0.2}, "grid-fine": {"density": 1e3, "cell": 0.05, "friction": 1.0},
    "grid-coarse": {"density": 1.0, "cell": 0.9, "friction": 0.0},
}  # fmt: skip
"""Settings of the rule interaction, for an L of 1."""
CONTACT = {
    "thin": {"thickness": 0.005, "iterations": 3},
    "thick": {"thickness": 0.02, "friction": 1.0, "iterations": 3},
}
"""Settings of the rule contact, for an L of 1."""
BETWEEN: dict[str, dict[str, dict[str, Any]]] = {
    "none": {},
    **{label: {"interaction": given} for label, given in GRID.items()},
    **{label: {"contact": given} for label, given in CONTACT.items()},
    "grid-thin": {"interaction": GRID["grid"], "contact": CONTACT["thin"]},
}
"""What strands do to each other: rules and their settings."""
TWIST: dict[str, dict[str, Any]] = {
    "none": {},
    "coil": {"rest": "shape"},
    "sag-free": {"rest": "sag_free"},
}
"""What strands twist by: settings of rod. Those of coils begin as such."""
OWN: dict[str, tuple[str, ...]] = {
    "between": tuple(BETWEEN),
    "twist": tuple(TWIST),
    "end": ("free", "pinned"),
    "root": ("clamped", "hinged"),
    "torsion": ("none", "0.7"),
}
"""Axes that the matrix does not have; the first value of each is its default."""
Row = tuple[str, ...]
PLAIN: Row = tuple(values[0] for values in OWN.values())
TURN, AXIS = 0.6, (0.8, 0.6, 0.0)
"""Radians by which a coil's edges turn from one to the next, about which unit vector."""


def valid(row: Row) -> bool:
    """Whether the product takes such a combination."""
    given = dict(zip(OWN, row, strict=True))
    return not (given["twist"] == "sag-free" and given["root"] == "hinged")


@cache
def rows(kinds: tuple[str, ...], touching: bool) -> tuple[Row, ...]:
    """All combinations with these kinds on and the others off, those with contact or those without."""
    found = []
    for row in product(*OWN.values()):
        on = tuple(kind for kind, label in zip(KINDS, row, strict=False) if label != "none")
        if on == kinds and ("contact" in BETWEEN[row[0]]) == touching and valid(row):
            found.append(row)
    return tuple(found)


def bends(case: Case) -> bool:
    """Whether the strands of a case have edges that a coil can be made of."""
    start = case.label("start")
    return not (start == "coincident" or (start == "zero" and case.value("n") == 1))


def met_by(case: Case, kinds: tuple[str, ...], touching: bool, count: int = 0) -> Iterator[Row]:
    """The combinations that a case meets, two or three unless a ``count`` is given."""
    place = _place(case)
    found = [row for row in rows(kinds, touching) if bends(case) or TWIST[row[1]].get("rest") != "shape"]
    for turn in range(count or 2 + (place % 4 == 0)):
        yield found[(place // 4 + turn * (len(found) // 2 + 1)) % len(found)]


def _place(case: Case) -> int:
    """A number by which a case's combinations are chosen."""
    return int.from_bytes(hashlib.blake2b(case.name.encode(), digest_size=8).digest(), "little")


def touching(quick: bool) -> list[Case]:
    """Cases that are tried with contact, which takes a hundred times as long as the grid: pairs of all axes, and a few
    of the rest. None is far from the origin, for coordinates are rounded there by more than strands are thick, and none
    has more than ten segments, which takes minutes."""
    if quick:
        found = sheets.quick("rod")[::TOUCHING]
    else:
        some = (case for case in sheets.full("rod") if _place(case) // 1024 % SELDOM == 0)
        found = [*sheets.pairs("rod"), *sheets.grooms("rod"), *some]
    short = {True: {"offset": "0"}, False: {"offset": "0", "n": "10"}}
    near = (Case.of("rod", case.parameters | short[case.value("n") <= 10]) for case in found)
    return [case for case in dict.fromkeys(near) if case.value("strands") <= MOST_TOUCHING]


def name_of(case: Case, row: Row) -> str:
    """A case's name and all that departs from the defaults of its own axes."""
    given = zip(OWN, row, strict=True)
    return "/".join([case.name, *(f"{axis}={label}" for axis, label in given if label != OWN[axis][0])])


def task_of(case: Case, row: Row) -> Task:
    """The piece of work of a case with a combination."""
    return Task(case.solver, (case,), name_of(case, row).partition("/")[2], labels=row)


def tasks(kinds: Sequence[str], quick: bool = False) -> list[Task]:
    """The matrix with these kinds on; the small one has one combination each."""
    wanted = tuple(kind for kind in KINDS if kind in kinds)
    cases = sheets.quick("rod") if quick else sheets.full("rod")
    free = "interaction" not in wanted
    found = [(case, row) for case in cases for row in met_by(case, wanted, False, int(quick or free))]
    if not free:
        found += [(case, row) for case in touching(quick) for row in met_by(case, wanted, True, 1)]
    return [task_of(case, row) for case, row in dict.fromkeys(found)]


def kernels_of(task: Task) -> tuple[Any, ...]:
    """What the kernels of a case depend on, but for double precision."""
    (case,), given = task.cases, dict(zip(OWN, task.labels, strict=True))
    rules = tuple(BETWEEN[given["between"]])
    return rules, case.label("contact") == "none"


def has_own_axes(name: str) -> bool:
    """Whether a name is of a case with more than the matrix has."""
    return any(part.partition("=")[0] in OWN for part in name.split("/"))


def named(name: str) -> Task:
    """The piece of work with a name. Raises `UsageError` that says which part is not known."""
    solver, *parts = name.split("/")
    own = [part for part in parts if part.partition("=")[0] in OWN]
    given = dict(zip(OWN, PLAIN, strict=True))
    for part in own:
        axis, _, label = part.partition("=")
        if label not in OWN[axis]:
            raise UsageError(f"--case {name}: {axis} has no value {shown(label)}; it has {', '.join(OWN[axis])}")
        given[axis] = label
    row = tuple(given.values())
    if solver != "rod" or not valid(row):
        raise UsageError(f"--case {name}: the product refuses such strands; --list --with names those that it takes")
    return task_of(case_named("/".join([solver, *(part for part in parts if part not in own)])), row)


def prepared(case: Case, row: Row) -> tuple[Scene, Started, NDArray[np.float64]]:
    """The scene of a case with a combination, its strands, and the ends of its steps."""
    given, L = dict(zip(OWN, row, strict=True)), case.value("L")
    if case.value("strands") == 1:
        labels = {**case.parameters, "strands": STRANDS}
        case = Case.of(case.solver, labels)
    times = times_of(case)
    rod, rules = TWIST[given["twist"]], BETWEEN[given["between"]]
    times = times[: math.ceil(len(times) / SHARE["contact" in rules])]
    scene, groom = scene_of(case, times), groom_of([case])
    assert groom.edges is not None
    if rod.get("rest") == "shape":
        groom = replace(groom, edges=coil(groom.edges))
    if case.label("contact") == "none":
        groom = replace(groom, roots=groom.roots * np.float32(CLOSE))
    matter: Rod = replace(
        scene.rod, radius=RADIUS * L, young=(scene.rod.young or 0.0) * (2 / (RADIUS * L)) ** 2,
        root=given["root"],
        torsion=None if given["torsion"] == "none" else float(given["torsion"]), end=given["end"], **rod,
    )  # fmt: skip
    uses = (
        RuleUse(name, registry()[name].Parameters(**_scaled(settings, L)), name) for name, settings in rules.items()
    )
    return replace(scene, rod=matter, rules=(*scene.rules, *uses)), groom, times


def _scaled(settings: Mapping[str, Any], L: float) -> dict[str, Any]:
    """Settings for an L of 1 for strands of any length."""
    powers = {"thickness": 1, "cell": 1, "density": -2}
    return {key: value * L ** powers[key] if key in powers else value for key, value in settings.items()}


def coil(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges (strands, n, 3), each turned by `TURN` more than the one before."""
    axis = np.array(AXIS)
    angle = TURN * np.arange(1, edges.shape[1] + 1)[:, None]
    along = (edges @ axis)[..., None] * axis
    return np.asarray(along + (edges - along) * np.cos(angle) + np.cross(axis, edges) * np.sin(angle))


def measured(case: Case, row: Row) -> dict[str, float]:
    """All that is measured in the matrix; in contact, how many segments pass through each other."""
    scene, groom, times = prepared(case, row)
    passing, meter, still = followed(case, scene, groom, times, _passing)
    found = meter.metrics(slice(None)) | still
    if passing is not None:
        contact = passing.contact
        found |= {"passed_told": passing.count(), "closeness": contact.penetration / contact.thickness}
    return found


def _passing(solver: Any) -> Passing | None:
    return None if solver.contact is None else Passing(solver)


def perform(task: Task) -> Verdict:
    """The verdict on one case."""
    (case,), (name,) = task.cases, task.names
    parameters = {**case.parameters, **dict(zip(OWN, task.labels, strict=True))}
    try:
        with np.errstate(all="ignore"):
            metrics = measured(case, task.labels)
    except Exception as error:  # whatever a solver raises is what is looked for here
        return judge(name, parameters, {}, f"{type(error).__name__}: {error}")
    return judge(name, parameters, metrics, unjudged=told_of(case))
