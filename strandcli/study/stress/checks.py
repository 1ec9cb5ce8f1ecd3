"""Checks that one extreme scene cannot make, by name: physics with a reference, rest, energy, repetition, a film.

The name that a check is listed under, after the solver's, is what replays it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from . import crowds, films, kept, physics, sameness, shaking, tunnelling
from .strand import Metrics

Check = Callable[[str], Metrics]

WAYS = {"level": (1.0, 0.0, 0.0), "up": (0.0, 1.0, 0.0), "hanging": (0.0, -1.0, 0.0), "rising": (1.0, 1.0, 0.0)}
PHYSICS: dict[str, Check] = {
    **{f"check=droop/gamma={g}": partial(physics.check_droop, gamma=g) for g in ("0.1", "1", "10")},
    **{f"check=order/gamma={g}": partial(physics.check_order, gamma=g) for g in ("1", "10")},
    **{
        f"check=buckling/gamma={g}/dt={dt}": partial(physics.check_buckling, gamma=g, dt=dt)
        for g in ("7.7", "7.9")
        for dt in ("60Hz", "0.5")
    },
    **{
        f"check=energy/B={B}/dt={dt}": partial(physics.check_energy, B=B, dt=dt)
        for B in ("0", "1e-6", "1e-2", "1", "1e2", "1e6")
        for dt in ("240Hz", "60Hz", "0.5")
    },
    "check=swing": physics.check_swing,
    **{f"check=swing/of={of}": partial(physics.check_mode, of=of) for of in ("beam", "chain")},
    **{
        f"check=sag-free/gamma={g}/n={n}/way={name}": partial(physics.check_sag, gamma=g, n=n, way=way)
        for g in ("1", "10", "100", "1e4")
        for n in (1, 2, 10, 32)
        for name, way in WAYS.items()
    },
    **{
        f"check=sag-free/gamma=1e4/n={n}/way={name}/dt={dt}": partial(
            physics.check_sag, gamma="1e4", n=n, way=way, dt=dt
        )
        for n, dt in ((10, "240Hz"), (10, "0.5"), (1000, "24Hz"))
        for name, way in WAYS.items()
    },
    "check=twist": physics.check_twist,
}
SAMENESS: dict[str, Check] = {
    **{
        f"check=rest{found}/dt={dt}/n={n}": partial(sameness.check_rest, contact=contact, dt=dt, n=n)
        for found, contact in (("", ""), ("/contact", "ball"), ("/contact=edge", "edge"))
        for dt in ("24Hz", "60Hz", "240Hz")
        for n in (10, 32)
    },
    "check=rest/dt=240Hz/n=10/precision=double": partial(sameness.check_rest, dt="240Hz", double=True),
    **{
        f"check=rate/gamma={g:g}/n={n}": partial(sameness.check_rate, gamma=g, n=n)
        for g in (1.0, 10.0, 100.0)
        for n in (10, 32)
    },
    **{f"check=substeps/n={n}": partial(sameness.check_substeps, n=n) for n in (10, 32)},
    "check=determinism": partial(sameness.check_determinism, labels={}),
    "check=determinism/contact=through": partial(sameness.check_determinism, labels={"contact": "through"}),
    "check=determinism/n=32": partial(sameness.check_determinism, labels={"n": "32"}),
    **{f"check=lengths/precision=double/n={n}": partial(sameness.check_double, n=n) for n in (10, 32, 100)},
}
FILMS: dict[str, Check] = {
    f"check=film/preset=hair/n={n}/substeps={substeps}": partial(
        films.check_film, preset="hair", particles=n + 1, substeps=substeps
    )
    for n, substeps in ((15, 1), (15, 8), (30, 16))
}
SHAKING: dict[str, Check] = {
    f"check=shake/way={way}/n={n}": partial(shaking.check_shake, way=way, n=n) for way in shaking.WAYS for n in (10, 32)
}
KEPT: dict[str, Check] = {
    f"check=segments/contact={contact}/n={n}": partial(kept.check_segments, contact=contact, n=n)
    for contact in kept.CONTACTS
    for n in (3, 10)
}
CHECKS = {**PHYSICS, **SAMENESS, **SHAKING, **KEPT, **FILMS, **crowds.CHECKS, **tunnelling.CHECKS}
"""By the name that follows the solver's."""

QUICK = (
    "check=droop/gamma=1", "check=buckling/gamma=7.7/dt=60Hz", "check=rest/dt=60Hz/n=10", "check=determinism",
    "check=twist", *tunnelling.QUICK,
)  # fmt: skip
"""Those that need few kernels of their own."""
