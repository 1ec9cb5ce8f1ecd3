"""What `strandcli doctor` looks at: software, machine, kernel cache, and a picture that is known."""

from __future__ import annotations

from typing import NamedTuple

OK, NOTE, BROKEN = "ok", "note", "broken"
"""All is well; worth knowing; strandcli does not work, or not rightly, until it is mended."""


class Finding(NamedTuple):
    """What was looked at, how it is, in words, and what to do ("" where there is nothing)."""

    check: str
    state: str
    text: str
    advice: str = ""
