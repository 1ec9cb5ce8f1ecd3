"""README and the pages of docs/, read as text: their code blocks, links and headings."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
NO_PRESET = "<!-- not a preset -->"
"""Stands on the line above a block of YAML that is something else."""


class Block(NamedTuple):
    """A fenced block of code."""

    page: Path
    line: int
    """Of its first line of text, from 1."""
    language: str
    text: str
    above: str
    """The line above the fence."""

    @property
    def place(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks(page: Path) -> list[Block]:
    """The fenced blocks of a page."""
    found, opened = [], None
    lines = page.read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines, 1):
        fence = re.match(r"(`{3,})(.*)$", line)
        if fence is None:
            continue
        if opened is None:
            opened = number, fence[2].strip(), fence[1]
        elif line.strip() == opened[2]:
            above = lines[opened[0] - 2] if opened[0] > 1 else ""
            found.append(Block(page, opened[0] + 1, opened[1], "\n".join(lines[opened[0] : number - 1]), above))
            opened = None
    assert opened is None, f"{page}:{opened[0]}: this block has no end"
    return found


def prose(page: Path) -> str:
    """A page's text without its fenced blocks, whose lines are left empty."""
    lines = page.read_text(encoding="utf-8").splitlines()
    for block in blocks(page):
        for number in range(block.line - 1, block.line + 1 + block.text.count("\n") + 1):
            lines[number - 1] = ""
    return "\n".join(lines)


def anchors(page: Path) -> set[str]:
    """What a link may name behind `#`: GitHub's names of headings."""
    found = set()
    for title in re.findall(r"^#{1,6} +(.+)$", prose(page), re.MULTILINE):
        plain = re.sub(r"[^\w\- ]", "", title.replace("`", "").lower())
        found.add(plain.strip().replace(" ", "-"))
    return found
