"""What strands may be and do beyond the matrix, with its extremes: they interact or touch, twist, are pinned at their
tips.

Every combination of these traits meets every two values of any two other axes. What solvers refuse by name counts as
refused, where it is known that they do; anything else that they raise has failed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.record import Groom
from ...scene.checks_of_rod import rod_clashes
from ...scene.model import RuleUse, Scene
from ...simulate import solver_of
from ...simulate.rod.pins import tips
from ...simulate.rules import registry
from .axes import AXES, DEFAULTS, Case
from .covering import covering
from .drive import Meter
from .scenes import groom_of, scene_of, times_of
from .strand import Metrics, Refused, only

STRANDS = "4"
"""Contact is dear, and of few strands and short ones it is as hard."""
CLOSE = 0.1
"""By how much roots are brought together where nothing is in their way: all strands meet there."""
RADIUS = 0.02
BETWEEN: dict[str, tuple[str, dict[str, Any]]] = {
    "none": ("", {}),
    "crowd": ("interaction", {"density": 10.0, "cell": 0.2}),
    "thin": ("contact", {"thickness": 0.005, "iterations": 3}),
    "thick": ("contact", {"thickness": 0.01, "friction": 1.0, "iterations": 3}),
}
"""What strands do to each other: a rule and its settings, lengths in L."""
TRAITS: dict[str, tuple[str, ...]] = {
    "between": tuple(BETWEEN),
    "rest": ("straight", "shape", "sag_free"),
    "end": ("free", "pinned"),
}
OTHERS: dict[str, tuple[str, ...]] = {
    "dt": ("1e-4", "240Hz", "60Hz", "24Hz", "0.5", "10", "noisy"),
    "B": ("0", "1e-2", "1", "1e6"),
    "gamma": ("0", "10", "1e4"),
    "wind": ("calm", "gale"),
    "emitter": ("still", "teleport", "flip", "shake"),
    "contact": ("none", "inside", "through", "overlap", "small", "moving"),
    "n": ("1", "2", "10"),
    "start": ("straight", "zero", "coincident", "folded", "random"),
    "root": ("clamped", "hinged"),
    "torsion": ("none", "0.7"),
}
LONG = ("0.5", "10")
FALL = 100.0
"""Steps, and ways that a strand would fall in one, L, beyond which its pull moves a pinned tip, whose mass is finite,
by more than a thousandth of L."""
QUIET: dict[str, tuple[str, ...]] = {
    **{axis: OTHERS[axis] for axis in ("dt", "B", "n", "start", "root", "torsion")},
    "gamma": ("10", "1e4"), "wind": ("calm",), "emitter": ("still",), "contact": ("none",),
}  # fmt: skip
"""Where nothing but weight works, so that energy may not grow: pairs of what is left."""
OWN = (*TRAITS, "root", "torsion")
"""Axes that the matrix does not have."""


def refusal(labels: dict[str, str]) -> str:
    """The words that the product refuses such a scene with; "" where it runs."""
    hanging = labels["root"] == "hinged" and labels["rest"] == "sag_free"
    return "rod.root: hinged roots hold no strand up" if hanging else ""


def prepared(labels: dict[str, str]) -> tuple[Scene, Groom, Case, NDArray[np.float64]]:
    """The scene of a combination, its strands, the matrix's case that it comes from, and the ends of its steps."""
    case = Case.of("rod", {**{axis: labels[axis] for axis in labels if axis not in OWN}, "strands": STRANDS})
    times = times_of(case)
    scene, groom = scene_of(case, times), groom_of([case])
    if labels["contact"] == "none":
        groom = replace(groom, roots=groom.roots * np.float32(CLOSE))
    rod = replace(
        scene.rod, radius=RADIUS, young=(scene.rod.young or 0.0) * (2 / RADIUS) ** 2,
        rest=labels["rest"], root=labels["root"],
        end=labels["end"],
        torsion=None if labels["torsion"] == "none" else float(labels["torsion"]),
    )  # fmt: skip
    name, given = BETWEEN[labels["between"]]
    rules = scene.rules
    if name:
        rules = (*rules, RuleUse(name, registry()[name].Parameters(**given), name))
    return replace(scene, rod=rod, rules=rules), groom, case, times


def check_traits(solver: str, *, labels: dict[str, str]) -> Metrics:
    """All that is measured in the matrix; how far pinned tips are from where they are held; energy gained where nothing
    but weight works on strands that start unbent."""
    only(solver, "rod", "its strands have none of these traits")
    scene, groom, case, times = prepared(labels)
    words = refusal(labels)
    try:
        for (path, *_), clash in rod_clashes(scene):  # as loading a preset does
            raise UsageError(f"{path}: {clash}")
        one: Any = solver_of(scene)(scene, groom)
    except UsageError as error:
        if words and words in str(error):
            raise Refused(str(error)) from error
        raise
    if words:
        return {"refused": 0.0}
    meter = Meter(scene, groom.lengths.astype(float) / case.value("n"), 1.0, touching=labels["contact"] != "none")
    energy, weight = [_height(one)], case.value("gamma") * (case.value("B") or 1.0)
    before = one.particles().astype(np.float64)
    past, off = 0.0, 0.0
    with np.errstate(all="ignore"):
        for time in times.tolist():
            one.step(time, time - past)
            now = one.particles()
            meter.look(now, time, one.strand_residuals())
            if one.pins is not None:
                off = max(off, _off(one))
            now = now.astype(np.float64)
            speed = (now - before) / (time - past)
            energy.append(_height(one) + float((speed**2).sum(2).mean()) / 2 / max(weight, 1e-300))
            before, past = now, time
    found = meter.metrics(slice(None))
    if one.pins is not None:
        found["pinned_off" if _undisturbed(labels) and _bearable(labels, weight) else "pinned_off_told"] = off
    if weight and _conservative(labels):
        # in long steps nothing bounds the energy of curled strands that turn far in one
        found["energy_gained_told" if labels["dt"] in LONG else "energy_gained"] = max(energy) - energy[0]
    if one.contact is not None:
        found["closeness"] = one.contact.penetration / one.contact.thickness
    return found


def _height(one: Any) -> float:
    return float(one.particles()[:, :, 1].astype(np.float64).mean())


def _off(one: Any) -> float:
    """Greatest distance of a tip from its pin, L."""
    pose = one.pose
    goals = np.einsum("ij,pjk->pik", np.array(pose.rotation), one.pins.places) + np.array(pose.translation)[:, None]
    return float(np.linalg.norm(goals - tips(one.state), axis=1).max())


def _undisturbed(labels: dict[str, str]) -> bool:
    """Whether neither solids nor other strands are in a strand's way."""
    return labels["contact"] == "none" and labels["between"] == "none"


def _bearable(labels: dict[str, str], weight: float) -> bool:
    """Whether a pinned tip can be held to its place."""
    return labels["dt"] not in LONG and weight * AXES["dt"][labels["dt"]] ** 2 <= FALL


def _conservative(labels: dict[str, str]) -> bool:
    """Whether nothing but weight works on strands that are not bent at the start; sag-free ones are, by their load."""
    unbent = labels["rest"] == "shape" or (labels["rest"] == "straight" and labels["start"] == "straight")
    return unbent and _undisturbed(labels) and labels["wind"] == "calm" and labels["emitter"] == "still"


def combinations() -> Iterator[dict[str, str]]:
    """Every combination of traits with every row of a covering of the other axes."""
    rows, quiet = covering(OTHERS), covering(QUIET)
    for labels in product(*TRAITS.values()):
        traits = dict(zip(TRAITS, labels, strict=True))
        found = rows + quiet if traits["between"] == "none" else rows
        yield from ({**{axis: row[axis] for axis in OTHERS}, **traits} for row in found)


def _name(row: dict[str, str]) -> str:
    given = (f"{axis}={row[axis]}" for axis in (*OTHERS, *TRAITS) if axis in OWN or row[axis] != DEFAULTS[axis])
    return "/".join(("check=traits", *given))


@cache
def table() -> dict[str, Callable[[str], Metrics]]:
    """The checks by name."""
    return {_name(row): partial(check_traits, labels=row) for row in combinations()}


def quick() -> list[str]:
    """Names of those of the table that are cheap: pinned tips, which need no kernel of their own, and refusals."""
    plain = {"between": "none", "rest": "straight", "end": "pinned", "root": "clamped", "torsion": "none"}
    found, words = [], set()
    for name, row in zip(table(), combinations(), strict=True):
        told = refusal(row)
        same = row["B"] != "1e6" and all(row[axis] == label for axis, label in plain.items())
        if same if not told else told not in words:
            found.append(name)
            words.add(told)
    return found
