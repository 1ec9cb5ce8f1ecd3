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
from ..errors import StrandError, UsageError
from ..output.claim import Claim
from ..output.files import prepare_folder, read_json, refusal, refuse_present, require_own, write_json, write_pieces
from ..output.report import finite
from ..run.fingerprint import fingerprint
from .layout import Labels, Layout
from .views import Chance, camera_of, lit

if TYPE_CHECKING:
    from ..scene.model import Scene
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
    """As `views.scene_for` makes it."""
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
        return write_manifest(order, finished(folder, made))
    from ..compiling import runtime
    from ..compiling.service import service
    from .studio import Studio

    claim = Claim(folder, FOLDER, wanted)
    try:
        runtime.start(threads, talk.notify)
        service.ahead(order.scene, threads)
        studio = Studio(order.scene, order.frame, talk.notify, talk.warn)
        try:
            _draw_all(order, studio, wanted, made, talk)
        finally:
            entries = finished(folder, made)
            if entries:
                _write_index(order, studio, entries)
            data = write_manifest(order, entries)
    finally:
        service.stop_ahead()
        claim.release()
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


FOLDER, KEY = "views", "made_from"
"""Of the entries of views; and what in each is the fingerprint of all that it depends on but its number."""


def name_of(view: int) -> str:
    """The name of a view, from 0; four digits at least."""
    return f"{view:04d}"


def entry_file(folder: Path, view: int) -> Path:
    """Where the entry of a view is."""
    return folder / FOLDER / f"{name_of(view)}.json"


def entry_of(folder: Path, view: int) -> dict[str, Any] | None:
    """What is known of a view whose files are all there; None where one is missing."""
    with suppress(StrandError, KeyError, TypeError):
        entry = read_json(entry_file(folder, view))
        if isinstance(entry[KEY], str) and all((folder / one).is_file() for one in entry["files"]):
            return dict(entry)
    return None


def finished(folder: Path, made_from: str) -> list[dict[str, Any]]:
    """The entries of all views of a set that are done, in order."""
    found = []
    for path in (folder / FOLDER).glob("*.json"):
        if path.stem.isdecimal():
            entry = entry_of(folder, int(path.stem))
            if entry is not None and entry[KEY] == made_from:
                found.append(entry)
    return sorted(found, key=lambda entry: int(entry["view"]))


def wanted_views(
    folder: Path, views: Sequence[int], paths: Sequence[str], made_from: str, resume: bool, overwrite: bool
) -> list[int]:
    """The views that have to be drawn. Raises `UsageError` for files that are in the way, and for views that were made
    from something else."""
    wanted = []
    for view in views:
        entry = entry_of(folder, view)
        if resume and entry is not None:
            if entry[KEY] != made_from:
                raise UsageError(
                    f"{entry_file(folder, view)}: was made from another groom, version or options, so --resume would "
                    "mix two sets; add --overwrite instead, or choose another folder with -o"
                )
            continue
        wanted.append(view)
        if not (resume or overwrite):
            there = [one for one in (path.format(name_of(view)) for path in paths) if (folder / one).exists()]
            refuse_present(folder, there[:1])
    return wanted


def write_manifest(order: Order, entries: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Write dataset.json; returns what it holds."""
    data = {
        "strandcli": __version__, "layout": order.layout.name, "groom": order.label, "frame": order.frame,
        "seed": order.chance.seed, "world": "metres, y up",
        "pixels": "from the upper left corner of the picture; the middle of the first is (0.5, 0.5)",
        "views": [{key: value for key, value in one.items() if key != KEY} for one in entries],
    }  # fmt: skip
    write_json(order.folder / OWN, data)
    return data
