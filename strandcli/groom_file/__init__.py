"""A scene whose strands are those of a file: the file read, placed and packed, and what of the scene depends on it."""

from .film import notes_of
from .following import Guided, completed, guided
from .read import FromFile, from_file, from_scene

__all__ = ["FromFile", "Guided", "completed", "from_file", "from_scene", "guided", "notes_of"]
