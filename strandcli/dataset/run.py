"""A data set of one groom, from the scene to the files."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..cameras import usd
from ..cameras.pinhole import UP, Pinhole, from_dict, of_camera, to_camera
from ..cameras.read import OWN
from ..output.claim import Claim
from ..output.files import prepare_folder, refusal, require_own, write_json, write_pieces
from ..output.report import finite
from ..run.fingerprint import fingerprint
from .layout import Layout
from .manifest import FOLDER, KEY, entry_file, finished, name_of, wanted_views, write_manifest
from .views import Chance, camera_of, lit

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .labels import Labels
    from .studio import Studio

BYTES_A_PIXEL = 14
CAMERAS = "cameras.usda"
NEAR = 0.01
"""Near plane of cameras from files, as a share of their distance from the middle of the strands."""
SMALLEST = 1e-6
"""Metres; of a near plane."""


@dataclass(frozen=True)
class Order:
    """What is asked for."""

    label: str
    """The groom as it was typed."""
    scene: Scene
    """As `order.scene_for` makes it."""
    folder: Path
    layout: Layout
    views: Sequence[int]
    """Numbers, from 0."""
    chance: Chance
    frame: int = 1
    places: Sequence[Pinhole] = ()
    """Of cameras from a file, one for each view; else they stand where chance puts them."""
    above: tuple[float, float, float] = UP
    """What is up where these stand."""
    resume: bool = False
    overwrite: bool = False


@dataclass
class Talk:
    """Whom a run tells what it does."""

    notify: Callable[[str], None] | None = None
    warn: Callable[[str], None] | None = None
    step: Callable[[str], None] = field(default=lambda text: None)
    """Handed a line when a view is done. May raise to end the run."""


def made_from(order: Order) -> str:
    """A fingerprint of all that a view of the set depends on but its number."""
    parts = [__version__, order.layout.name, fingerprint(order.scene), repr(order.chance), str(order.frame)]
    parts += [repr(place.as_dict()) for place in order.places]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:32]


def make(order: Order, threads: int | None, talk: Talk) -> dict[str, Any]:
    """Draw the views that are not there, and write what belongs to all; returns what dataset.json holds.

    However it ends, views that are done stay, and dataset.json has them. Raises `UsageError` and `RefusedError` for a
    folder that cannot take them before anything is drawn.
    """
    made = made_from(order)
    folder, layout = order.folder, order.layout
    wanted = wanted_views(folder, order.views, layout.paths, made, order.resume, order.overwrite)
    if not order.overwrite:
        require_own(folder / OWN)
    width, height = order.scene.image.size
    prepare_folder(folder, len(wanted) * width * height * BYTES_A_PIXEL)
    for part in {Path(path).parent for path in (*layout.paths, f"{FOLDER}/0")}:
        prepare_folder(folder / part, 0)
    if not wanted and (folder / OWN).exists():
        return _listed(order, made)
    claim = Claim(folder, FOLDER, wanted)
    try:
        return _drawn(order, wanted, made, threads, talk)
    finally:
        claim.release()


def _drawn(order: Order, wanted: Sequence[int], made: str, threads: int | None, talk: Talk) -> dict[str, Any]:
    """Draw views and finish the set."""
    from ..compiling import runtime
    from ..run import compile_ahead
    from .studio import Studio

    runtime.start(threads, talk.notify)
    compile_ahead.begin(order.scene, threads)
    try:
        studio = Studio(order.scene, order.frame, talk.notify, talk.warn)
        try:
            _draw_all(order, studio, wanted, made, talk)
        finally:
            entries = finished(order.folder, made)
            if entries:
                _write_index(order, studio, entries)
            data = write_manifest(order.folder, _facts(order), entries)
    finally:
        compile_ahead.end()
    return data


def _draw_all(order: Order, studio: Studio, wanted: Sequence[int], made: str, talk: Talk) -> None:
    """Draw one view after the other; the files of each are written while the next is drawn."""
    with ThreadPoolExecutor(1, "dataset writer") as writer:
        before: Future[str] | None = None
        for view in wanted:
            began = time.perf_counter()
            place, near = _place(order, studio, view)
            camera = to_camera(place, near)
            scene, facts = lit(replace(order.scene, camera=camera), order.chance, view, place, order.above)
            labels, drawing = studio.draw(scene, place)
            if before is not None:
                talk.step(before.result())
            entry = {
                "view": view, "name": place.name, "seed": order.chance.seed, "camera": place.as_dict(), **facts,
                "seconds": drawing.seconds, "drawn": time.perf_counter() - began, KEY: made,
            }  # fmt: skip
            before = writer.submit(_write, order, labels, entry)
        if before is not None:
            talk.step(before.result())


def _place(order: Order, studio: Studio, view: int) -> tuple[Pinhole, float]:
    """Where the camera of a view stands, and its near plane, metres."""
    if order.places:
        place = replace(order.places[view], name=name_of(view))
        away = abs(float((studio.cloud.middle - place.eye) @ place.rotation[2]))
        return place, max(NEAR * away, SMALLEST)
    size = order.scene.image.size
    camera = camera_of(order.chance, view, order.scene.camera, studio.points, size)
    return of_camera(camera, name_of(view), *size), camera.near


def _write(order: Order, labels: Labels, entry: dict[str, Any]) -> str:
    """Write the files of a view, and its entry last; returns a line about it."""
    began = time.perf_counter()
    paths = [path.format(labels.view.name) for path in order.layout.paths]
    entry_file(order.folder, entry["view"]).unlink(missing_ok=True)  # of a set that this one replaces
    for path, pieces in zip(paths, order.layout.encode(labels), strict=True):
        write_pieces(order.folder / path, pieces)
    share = float(labels.hair.mean())
    entry = {**entry, "hair_share": share, "files": paths}
    entry["seconds"] = {**entry["seconds"], "write": time.perf_counter() - began}
    write_json(entry_file(order.folder, entry["view"]), finite(entry))
    return f"view {labels.view.name}: hair on {share:.1%} of the picture, {entry.pop('drawn'):.2f} s"


def _write_index(order: Order, studio: Studio, entries: Sequence[dict[str, Any]]) -> None:
    """Write the files of all views together, and their cameras for programs that read USD."""
    views = [from_dict(entry["camera"]) for entry in entries]
    for path, pieces in {CAMERAS: [usd.written(views)], **order.layout.index(views, studio.cloud)}.items():
        prepare_folder((order.folder / path).parent, 0)
        write_pieces(order.folder / path, pieces)
    for link, target in order.layout.links().items():
        place = order.folder / link
        try:
            with suppress(FileExistsError):
                os.symlink(target, place, target_is_directory=True)
        except OSError as error:
            raise refusal(error, place) from error


def _facts(order: Order) -> dict[str, Any]:
    """The head of dataset.json."""
    return {
        "layout": order.layout.name,
        "groom": order.label,
        "frame": order.frame,
        "seed": order.chance.seed,
        "world": "metres, y up",
        "pixels": "from the upper left corner of the picture; the middle of the first is (0.5, 0.5)",
    }


def _listed(order: Order, made: str) -> dict[str, Any]:
    """What dataset.json holds where nothing had to be drawn."""
    return write_manifest(order.folder, _facts(order), finished(order.folder, made))
