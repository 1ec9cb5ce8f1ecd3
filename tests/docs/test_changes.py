"""changes/: a file a change, which `make changelog` moves into CHANGELOG.md."""

from __future__ import annotations

from pathlib import Path

import pytest

from changes import fold as program
from pages import ROOT

MOST_WORDS = 1500


def test_each_change_is_a_line_and_the_changelog_short() -> None:
    for path, text in program.fragments().items():
        assert 0 < len(text) <= 120, path.name
        assert "\n" not in text, path.name
    assert len((ROOT / "CHANGELOG.md").read_text(encoding="utf-8").split()) <= MOST_WORDS


def test_fragments_go_into_the_section_of_their_version() -> None:
    found = {Path("a.added.md"): "A.", Path("b.fixed.md"): "B."}
    old = "# C\n\n## 0.1.0\n\n### Added\n\n- Z.\n"
    fixed = "### Fixed\n\n- B.\n"
    assert program.folded(old, "0.2.0", found) == (
        f"# C\n\n## 0.2.0\n\n### Added\n\n- A.\n\n{fixed}\n## 0.1.0\n\n### Added\n\n- Z.\n"
    )
    assert program.folded(old, "0.1.0", found) == f"# C\n\n## 0.1.0\n\n### Added\n\n- A.\n- Z.\n\n{fixed}"


def test_a_fragment_of_no_kind_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.new.md").write_text("A.", encoding="utf-8")
    with pytest.raises(ValueError, match="KIND"):
        program.fragments(tmp_path)
