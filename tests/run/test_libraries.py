"""Memory that libraries' files take: read of the system, kept for each environment, reckoned with by plans."""

from __future__ import annotations

from pathlib import Path

import pytest

from strand_kit import scene_of
from strandcli.compiling.folder import cache
from strandcli.plan import libraries, make_plan

SMAPS = """\
7f00-7f10 r--p 00000000 fe:00 123    /env/lib/libllvm one.so
Rss:    9 kB
7f10-7f20 r-xp 00000000 fe:00 123    /env/lib/libllvm.so.15
Size:                100 kB
Rss:                  40 kB
7f20-7f30 rw-p 00000000 00:00 0
Rss:                 500 kB
7f30-7f40 r--p 00000000 fe:00 124    /env/lib/data.bin
Rss:                 700 kB
7f40-7f50 r--p 00000000 fe:00 125    /env/lib/core.cpython-311.so
Rss:                   2 kB
VmFlags: rd mr mw me
"""


def test_mapped_pages_of_libraries_count_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "smaps").write_text(SMAPS)
    assert libraries.mapped_bytes(tmp_path / "smaps") == 51 * 1024
    assert libraries.mapped_bytes(tmp_path / "none") == 0


@pytest.mark.parametrize("content", ["", "[]", "{", '{"a": "x"}', '{"a": 1}'])
def test_plans_reckon_with_what_was_kept(content: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "_path", tmp_path)
    monkeypatch.setattr(libraries._Known, "bytes", libraries.USUAL)
    scene = scene_of("emitter: {strands: 10, particles: 3}")
    before = make_plan(scene, [1]).memory_bytes
    (tmp_path / libraries.FILE).write_text(content)
    libraries.look()
    assert make_plan(scene, [1]).memory_bytes == before
    libraries.keep(1)  # not to be believed
    libraries.keep(libraries.USUAL + 7_000_000)
    libraries.look()
    assert make_plan(scene, [1]).memory_bytes == before + 7_000_000
