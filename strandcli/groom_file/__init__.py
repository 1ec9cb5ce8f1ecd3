"""A scene whose strands are those of a file: the file read, placed and packed, and what of the scene depends on it."""

from .complete import completed
from .read import FromFile, from_file

__all__ = ["FromFile", "completed", "from_file"]
