"""Where `quality: draft, default, best` stand beside the front of settings of drawing, in windows of the whole frame.

Unlike the axis end to end, all strands are there and pixels are those of the picture: strands that are a fifth of a
pixel wide and crowded have errors several times those of the first 2,000 in a small picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...scene.quality import QUALITIES
from ..axes import Axis, Request
from ..points import Knobs, Point, described, grid
from .end_to_end import WholeStudy
from .experiment import Pictures
from .frame_study import FINEST, FrameStudy
from .settings import changed
from .windows import Windows

SAMPLES = (1, 2, 3, 4, 6)
TOLERANCES = (0.1, 0.25, 1.0)


class QualityStudy(FrameStudy):
    """The three by name, and samples, tolerances and levels of detail about them, all of the settings of `default`
    else. Every one is drawn, however long that takes."""

    axis = "quality"

    def open_subject(self, request: Request) -> Windows:
        """As in `FrameStudy`; times are the processor's, so that other programs do not move the front."""
        found = super().open_subject(request)
        found.of_processor = True
        return found

    def choices(self) -> list[Knobs]:
        """Those by name, then the grid."""
        found: list[Knobs] = [{"quality": name} for name in ("preset", *QUALITIES)]
        fine = {"curves.mode": "adaptive", "curves.level": FINEST}
        found += [{**fine, **knobs} for knobs in grid({"image.supersample": SAMPLES, "curves.tolerance": TOLERANCES})]
        return found + [{**fine, "curves.tolerance": 1.0, "detail.pixels": pixels} for pixels in (0.25, 0.5, 0.75)]

    def reference(self) -> dict[str, Any]:
        """As in `FrameStudy`."""
        told = super().reference()
        return {**told, "what": f"{told['what']}; seconds are the processor's, of a whole frame"}

    def settings(self) -> list[Knobs]:
        """Those that the preset has."""
        return Pictures.settings(self)

    def paths(self, knobs: Knobs) -> Knobs:
        """Of a name what it stands for; of the grid what it changes of `default`."""
        if "quality" in knobs:
            return WholeStudy.paths(self, knobs)
        return {**WholeStudy.paths(self, {"quality": "default"}), **knobs}

    def series(self, knobs: Knobs) -> str:
        """By name, or of the grid."""
        return "by name" if "quality" in knobs else "grid"

    def measure(self, knobs: Knobs) -> Point:
        """Draw one setting."""
        return Pictures.measure(self, knobs)


def standing(points: Sequence[Point]) -> dict[str, dict[str, Any]]:
    """By quality its seconds and errors, and the cheapest setting that is no more than a fiftieth farther off, by how
    much of its time; itself where there is none cheaper."""
    found = {}
    for point in points:
        error = point.error["rmse"]
        if "quality" not in point.knobs or error is None:
            continue
        known = [(other, other.error["rmse"]) for other in points]
        near = [other for other, off in known if off is not None and off <= 1.02 * error]
        best = min(near, key=lambda other: other.seconds)
        found[str(point.knobs["quality"])] = {
            "seconds": point.seconds,
            "error": dict(point.error),
            "cheapest": dict(best.knobs),
            "of_its_time": best.seconds / point.seconds if point.seconds else 1.0,
        }
    return found


def to_text(points: Sequence[Point]) -> str:
    """A line a quality: where it stands."""
    lines = ["beside the cheapest setting that is at most a fiftieth farther off:"]
    for name, told in standing(points).items():
        own = told["cheapest"].get("quality") == name
        other = (
            "it is the cheapest"
            if own
            else f"{described(told['cheapest'])} takes {told['of_its_time']:.0%} of its time"
        )
        error = told["error"]
        lines.append(f"  {name:<9}{error['rmse']:6.1%}, ꟻLIP {error['flip']:.3f}, {told['seconds']:.2f} s: {other}")
    return "\n".join(lines)


def _opened(request: Request) -> QualityStudy:
    """The study of a request; all strands are drawn, at the preset's own size or the one asked for."""
    assert request.scene is not None
    scene = request.scene if request.size is None else changed(request.scene, {"image.size": request.size})
    return QualityStudy(Request(scene=scene, name=request.name, frame=request.frame, fixed=request.fixed))


AXIS = Axis(
    name="quality", doc="quality by name and settings about it, in windows of the whole frame, against a converged one",
    knobs=("quality", "image.supersample", "curves.tolerance", "detail.pixels"),
    metric="rmse", of_preset=True, open=_opened, pictures=True,
)  # fmt: skip
