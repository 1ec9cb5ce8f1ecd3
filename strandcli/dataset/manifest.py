"""What is known of each view: ``views/0000.json``, which is written last and says that its files are all there, and
dataset.json, which has all of them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from .. import __version__
from ..cameras.read import OWN
from ..errors import UsageError
from ..output.files import read_json, refuse_present, write_json

FOLDER = "views"
KEY = "made_from"
"""Fingerprint of all that a view depends on but its number."""


def name_of(view: int) -> str:
    """The name of a view, from 0; four digits at least."""
    return f"{view:04d}"


def entry_file(folder: Path, view: int) -> Path:
    """Where the entry of a view is."""
    return folder / FOLDER / f"{name_of(view)}.json"


def entry_of(folder: Path, view: int) -> dict[str, Any] | None:
    """What is known of a view whose files are all there; None where one is missing."""
    with suppress(OSError, ValueError, KeyError, TypeError):
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


def write_manifest(folder: Path, facts: dict[str, Any], entries: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Write dataset.json; returns what it holds."""
    data = {"strandcli": __version__, **facts, "views": [{k: v for k, v in one.items() if k != KEY} for one in entries]}
    write_json(folder / OWN, data)
    return data
