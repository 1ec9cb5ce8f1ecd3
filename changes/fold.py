"""Moves the fragments of this folder into CHANGELOG.md: python changes/fold.py VERSION."""

from __future__ import annotations

import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
KINDS = ("added", "changed", "fixed", "removed")


def fragments(folder: Path = HERE) -> dict[Path, str]:
    """Return each fragment with its text.

    :raises ValueError: a file whose name ends in no kind
    """
    found = {path: path.read_text(encoding="utf-8").strip() for path in sorted(folder.glob("*.*.md"))}
    for path in found:
        if kind_of(path) not in KINDS:
            raise ValueError(f"{path.name}: name it NAME.KIND.md, with a KIND of {', '.join(KINDS)}")
    return found


def kind_of(path: Path) -> str:
    return path.name.split(".")[-2]


def folded(changelog: str, version: str, found: dict[Path, str]) -> str:
    """Return ``changelog`` with the fragments in the section of ``version``, which is added on top if it is missing."""
    title = f"## {version}\n"
    if title not in changelog:
        changelog = re.sub(r"^(?=## )", f"{title}\n", changelog, count=1, flags=re.MULTILINE)
    before, _, rest = changelog.partition(title)
    section, separator, after = f"\n{rest}".partition("\n## ")
    for kind in KINDS:
        lines = "".join(f"- {text}\n" for path, text in found.items() if kind_of(path) == kind)
        heading = f"### {kind.capitalize()}\n\n"
        if lines and heading in section:
            section = section.replace(heading, heading + lines)
        elif lines:
            section = f"{section.rstrip()}\n\n{heading}{lines}"
    return before + title.rstrip() + section + separator + after


def main(version: str) -> None:
    found, changelog = fragments(), HERE.parent / "CHANGELOG.md"
    changelog.write_text(folded(changelog.read_text(encoding="utf-8"), version, found), encoding="utf-8")
    for path in found:
        path.unlink()


if __name__ == "__main__":
    main(sys.argv[1])
