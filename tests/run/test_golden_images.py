"""Every shipped preset draws the picture that was once looked at and found good.

On machines of a class that is recorded to the bit, on others within the tolerance of `strandcli.study.golden`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from strandcli.study import golden
from strandcli.study.golden_list import Entry, read_entries

GOLDEN = Path(__file__).parents[1] / "golden"
ENTRIES = read_entries(GOLDEN)


@pytest.mark.parametrize("entry", ENTRIES, ids=[entry.name for entry in ENTRIES])
def test_it_is_the_picture_on_record(entry: Entry, tmp_path: Path) -> None:
    found = golden.check(GOLDEN, entry, tmp_path, golden.draw)
    assert found.matches, found.words
