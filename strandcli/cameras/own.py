"""Views in the dataset.json of a data set that strandcli wrote, orthographic ones too."""

from __future__ import annotations

from pathlib import Path

from ..errors import UsageError
from ..output.files import read_json
from .pinhole import Pinhole, from_dict

FILE = "dataset.json"


def read(path: Path) -> list[Pinhole]:
    """The views in order. Raises `UsageError` for a file that is none."""
    try:
        data = read_json(path)
        views = [from_dict(entry["camera"]) for entry in data["views"]]
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (KeyError, TypeError, ValueError, OverflowError):
        raise UsageError(f"{path}: is no {FILE} of strandcli") from None
    if not views:
        raise UsageError(f"{path}: holds no view")
    return views
