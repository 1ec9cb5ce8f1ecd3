"""What the thesis claims, measured here: `strandcli claims`.

Every row is a claim, the source's own figure (thesis §4) and ours, on this machine as it is now.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import load
from ..compiling import runtime
from ..scene.model import Scene
from .bench import at_first_frame, time_frames
from .chart import FAINT, GRID, INK, drawing, line, marker, text

Notify = Callable[[str], None]


def run(threads: int | None = None, notify: Notify | None = None, repeats: int = 5) -> dict[str, Any]:
    """{"claims": rows, "busy": as of `Load.since`, of the busiest repeat, "machine": …}. Rows: see `row`."""
    tell = notify or (lambda text: None)
    runtime.start(threads, notify)
    timed = []
    for repeat in range(repeats):
        tell(f"frames a second, shares of a frame: {repeat + 1} of {repeats}")
        timed.append(_timed(threads))
    rows = _speed(timed)
    tell("stiffness under another step")
    rows += [_stiffness(), _trembling()]
    tell("points and segments against a thin capsule")
    rows.append(_tunnelling())
    tell("fewer strands, near and far")
    rows += _fewer(threads)
    busy = max((one["busy"] for one in timed if one["busy"]), key=lambda one: one["others"], default=None)
    return {"claims": rows, "busy": busy, "machine": runtime.machine()}


def row(
    claim: str, source: str, ours: str, quantity: str, values: Sequence[float], span: tuple[float, float] | None = None
) -> dict[str, Any]:
    """A claim with the source's figure, ours in words, our ``values`` of a quantity, one for each repeat where time is
    measured, and the ``span`` of the source's figure."""
    return {
        "claim": claim, "source": source, "ours": ours, "quantity": quantity, "values": [float(v) for v in values],
        "range": span and list(span),
    }  # fmt: skip


def _timed(threads: int | None) -> dict[str, Any]:
    """Figures of one repeat: frames a second, and shares of a frame."""
    timed = {
        name: time_frames(load("headline", settings={"time.frames": 20, **settings}), frames, threads, None)
        for name, settings, frames in (
            ("all", {}, 12),
            ("straight", {"curves.mode": "off"}, 12),
            ("many", {"emitter.strands": 100_000, "emitter.particles": 9}, 4),
        )
    }
    frame = {name: one["frame_ms"] for name, one in timed.items()}
    stage = {name: 1e3 * float(np.median(values)) for name, values in timed["all"]["seconds"].items()}
    work = sum(value for name, value in stage.items() if name != "write")
    return {
        "fps": 1e3 / frame["all"], "many": 1e3 / frame["many"], "smoothing": 100 * stage["curves"] / work,
        "saved": 100 * (1 - frame["straight"] / frame["all"]), "shadow": 100 * stage["shadow"] / work,
        "busy": timed["all"]["busy"],
    }  # fmt: skip


def _speed(timed: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    values = {name: [one[name] for one in timed] for name in ("fps", "many", "smoothing", "saved", "shadow")}
    words = {name: spread_words(found) for name, found in values.items()}
    return [
        row(
            "10,000 strands of 10 particles, all on, 800x600: frames a second", "25-30 (2012, drawn by a GPU)",
            f"{words['fps']} (CPU alone, PNG files written)", "frames a second", values["fps"], (25, 30),
        ),
        row(
            "100,000 strands, 900,000 particles: frames a second", "PhysX on a GPU: 840,000 particles",
            words["many"], "frames a second", values["many"],
        ),
        row(
            "smoothing's share of a frame", "30-50 %",
            f"{words['smoothing']} % in its own stage; a frame of straight segments takes {words['saved']} % less",
            "%", values["smoothing"], (30, 50),
        ),
        row(
            "the shadow map's share of a frame", "about 5 % of CPU time", f"{words['shadow']} %",
            "%", values["shadow"], (5, 5),
        ),
    ]  # fmt: skip


def spread_words(values: Sequence[float]) -> str:
    """The median of repeats, with the least and the greatest of them."""
    middle = f"{np.median(values):.3g}"
    return middle if len(values) < 2 else f"{middle} ({min(values):.3g} to {max(values):.3g})"


def _stiffness() -> dict[str, Any]:
    """Where tips rest under gravity and stiffness, for one step length against another."""
    tips = {fps: rest(_drooping(fps))[:, -1] for fps in (30, 60, 120)}
    drift = {fps: 100 * float(np.linalg.norm(tips[fps] - tips[30], axis=-1).mean()) for fps in (60, 120)}
    return row(
        "stiffness changes when the step changes: how far resting tips move", "admitted, no figure",
        f"{drift[60]:.0f} % of a strand's length from 1/30 to 1/60 s, {drift[120]:.0f} % to 1/120 s",
        "% of a length", [drift[60]],
    )  # fmt: skip


def _trembling() -> dict[str, Any]:
    """How far from each other places are that resting tips come to, with steps longer and shorter by a half."""
    equal, varied = (100 * tremble(_drooping(24, 8.0, jitter)) for jitter in (0.0, 0.5))
    return row(
        "stiffness trembles when steps vary: reach of resting tips, steps of 1/24 s longer and shorter by half",
        "admitted, no figure", f"{varied:.2g} % of a strand's length; {equal:.2g} % with equal steps",
        "% of a length", [varied],
    )  # fmt: skip


def tremble(scene: Scene, frames: int = 60) -> float:
    """The diagonal of the box that a tip stays in after the scene's pre-roll, metres, the mean of all strands."""
    solver, tips = at_first_frame(scene), []
    for frame in range(1, frames + 1):
        solver.advance(frame)
        tips.append(solver.particles()[:, -1])
    return float(np.linalg.norm(np.ptp(tips, axis=0), axis=-1).mean())


def _drooping(fps: int, preroll: float = 4.0, jitter: float = 0.0) -> Scene:
    return load("headline", settings={
        "time.jitter": jitter, "emitter.strands": 256, "emitter.length": 1.0, "emitter.length_variation": 0.0,
        "emitter.keys": [], "time.fps": fps, "time.preroll": preroll,
        "rules": ["gravity", {"stiffness": {"strength": 40.0}}, "elasticity"],
    })  # fmt: skip


def rest(scene: Scene) -> NDArray[np.float32]:
    """(strands, particles, 3) after the scene's pre-roll."""
    return at_first_frame(scene).particles()


def _tunnelling() -> dict[str, Any]:
    """Strands that reach level through a thin capsule: the share still cut by it once they have come to rest."""
    shares = {}
    axis = np.array([-2, 0.86, 0.5]), np.array([2, 0.86, 0.5])
    for segments in (False, True):
        scene = load("headline", settings={
            "emitter.shape": {"kind": "plane", "width": 2.0, "depth": 0.2}, "emitter.position": [0, 0.85, 0],
            "emitter.keys": [], "emitter.direction": [0, 0, 1], "emitter.strands": 1024, "emitter.particles": 6,
            "emitter.length": 1.5, "emitter.length_variation": 0.3, "time.preroll": 1.0, "time.fps": 60,
            "solids": [
                {"kind": "capsule", "radius": 0.03, "length": 4, "position": [0, 0.86, 0.5], "rotation": [0, 0, 90]},
            ],
            "rules": [{"collision": {"segments": segments}}, "elasticity"],
        })  # fmt: skip
        shares[segments] = cut_share(rest(scene), *axis, 0.03)
    return row(
        "strands cut by a capsule of radius 0.03, segments about 0.3 long: points against segments",
        "admitted for points, no figure",
        f"{100 * shares[False]:.0f} % with points, {100 * shares[True]:.0f} % with segments: true",
        "% of strands, points", [100 * shares[False]],
    )  # fmt: skip


def cut_share(strands: NDArray[np.floating], a: NDArray[np.floating], b: NDArray[np.floating], radius: float) -> float:
    """Share of strands (S, n, 3) of which any of 33 points a segment is deeper than half the radius in the capsule
    from a to b."""
    t = np.linspace(0, 1, 33)[:, None]
    points = strands[:, :-1, None] + t * (strands[:, 1:, None] - strands[:, :-1, None])
    along = np.clip(((points - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
    away = np.linalg.norm(points - a - along[..., None] * (b - a), axis=-1)
    return float((away < 0.5 * radius).any((1, 2)).mean())


def _fewer(threads: int | None) -> list[dict[str, Any]]:
    """Pictures of fewer strands against that of 10,000, as they are and widened to keep their area."""
    rows = []
    for distance in (50, 150):
        full = _picture(distance, 10_000, 1, threads)
        for strands in (5_000, 1_000):
            plain = _difference(_picture(distance, strands, 1, threads), full)
            wide = _difference(_picture(distance, strands, 10_000 // strands, threads), full)
            rows.append(row(
                f"{strands:,} strands instead of 10,000 at distance {distance}", "looks the same when far",
                f"RMSE {plain['rmse']:.1f} of 255, area x{plain['area']:.2f}; widened: RMSE {wide['rmse']:.1f}, "
                f"area x{wide['area']:.2f}", "RMSE of 255", [plain["rmse"]],
            ))  # fmt: skip
    return rows


def _picture(distance: float, strands: int, wider: int, threads: int | None) -> NDArray[np.uint8]:
    from ..run import pipeline

    scene = load("headline", settings={
        "emitter.strands": strands, "emitter.shape": {"kind": "sphere", "radius": 8.0}, "emitter.length": 6.0,
        "emitter.keys": [], "solids": [], "time.frames": 1,
        "rules": [{"gravity": {"acceleration": [0, -200.0, 0]}}, {"stiffness": {"strength": 40.0}}, "elasticity"],
        "camera": {"position": [0, 0, distance], "target": [0, 0, 0], "fov": 40},
        "image.supersample": 4, "image.background": [0.0, 0.0, 0.0], "image.horizon": None,
        # the width of a line at distance 50 in a picture 600 high
        "material.width": wider * 50 * 2 * 0.36397 / 600, "material.taper": 0.0,
    })  # fmt: skip
    image = next(iter(pipeline.render(scene, [1], threads=threads))).image
    assert image is not None
    return image


def _difference(image: NDArray[np.uint8], reference: NDArray[np.uint8]) -> Mapping[str, float]:
    """Root mean square over all pixels in 8-bit units, and the ratio of covered areas."""
    error = float(np.sqrt(np.mean((image.astype(float) - reference) ** 2)))
    return {"rmse": error, "area": covered(image) / covered(reference)}


def covered(image: NDArray[np.uint8]) -> float:
    """Pixels that are not black, each by its brightness up to a twentieth of white."""
    return float(np.minimum(image.max(-1).astype(float) / 12.75, 1.0).sum())


WIDTH, TOP, ROW = 1080, 70.0, 44.0
LEFT, RIGHT = 560.0, 170.0
BAND, OURS = "#cfd8e3", "#d55e00"
"""Of the chart, pixels and colours."""


def chart(rows: Sequence[Mapping[str, Any]]) -> str:
    """The chart as SVG: a row a claim, the source's range and our repeats, on an axis of its own that begins at 0."""
    what = "grey: the source's range; dot: ours, the median; line: the least and the greatest of our repeats"
    items = [text((24, 26), "What the thesis claims, measured", INK, 19), text((24, 50), what, FAINT, 13)]
    for place, row in enumerate(rows):
        y, values, source = TOP + ROW * (place + 0.5), row["values"], row["range"] or []
        middle = statistics.median(values)
        span = (WIDTH - LEFT - RIGHT) / (1.1 * max(*values, *source, 1e-9))
        x = [LEFT + span * value for value in (min(values), middle, max(values))]
        items += [text((24, y), row["claim"], INK, 12), line([(LEFT, y), (WIDTH - RIGHT, y)], GRID)]
        if source:
            low, high = (LEFT + span * value for value in source)
            items.append(line([(low - 1, y), (high + 1, y)], BAND, 18))
        items += [line([(x[0], y), (x[2], y)], OURS, 3), marker("disc", (x[1], y), 5, OURS, "#ffffff")]
        items.append(text((WIDTH - RIGHT + 10, y), f"{middle:.3g} {row['quantity']}", INK, 12))
    return drawing(WIDTH, TOP + ROW * len(rows) + 20, items)
