"""Views in the dataset.json of a data set that strandcli wrote, orthographic ones too."""

from __future__ import annotations

from pathlib import Path

from ..errors import UsageError
from ..files.inputs import content
from ..output.files import json_of
from .pinhole import Pinhole, from_dict

FILE = "dataset.json"


def read(path: Path) -> list[Pinhole]:
    """The views in order. Raises `UsageError` for a file that is none."""
    try:
        data = json_of(content(path))
        views = [from_dict(entry["camera"]) for entry in data["views"]]
    except (KeyError, TypeError, ValueError, OverflowError):
        raise UsageError(f"{path}: is no {FILE} of strandcli") from None
    if not views:
        raise UsageError(f"{path}: has no view")
    return views
