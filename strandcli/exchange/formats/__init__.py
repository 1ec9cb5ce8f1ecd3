"""Formats of files of strands, a module each, found by its file; `strandcli.exchange.files` says what each has."""

from __future__ import annotations

import ast
import re
from pathlib import Path

SUFFIXES = re.compile(r"^suffixes = (\(.+\))$", re.MULTILINE)


def suffixes() -> tuple[str, ...]:
    """Ends of names of files of all formats here, without importing them: NumPy comes with them."""
    found = [SUFFIXES.search(one.read_text("utf-8")) for one in sorted(Path(__file__).parent.glob("*.py"))]
    return tuple(suffix for one in found if one for suffix in ast.literal_eval(one[1]))
