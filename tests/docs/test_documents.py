"""README and docs/: links resolve, commands exist, presets load, the README's Python runs."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import click
import pytest

import strandcli
from pages import NO_PRESET, PAGES, ROOT, Block, anchors, blocks, prose
from strandcli.cli.main import cli
from strandcli.scene.quality import QUALITIES

MOST_WORDS = 900
LINK = re.compile(r"\]\(([^)\s]+)\)")


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").split()) <= MOST_WORDS


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_resolve(page: Path) -> None:
    wrong = []
    for target in LINK.findall(prose(page)):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, anchor = target.partition("#")
        there = page if not file else (page.parent / file).resolve()
        if not there.exists() or (anchor and anchor not in anchors(there)):
            wrong.append(target)
    assert not wrong


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_files_of_the_project_are_where_pages_say(page: Path) -> None:
    named = re.findall(r"`((?:strandcli|tests|examples|presets|docs)/[\w/.]+)`", page.read_text(encoding="utf-8"))
    assert [name for name in named if "NAME" not in name and not (ROOT / name).exists()] == []


def test_every_page_and_picture_is_linked() -> None:
    """Each page from the index and from the README, each picture from the README."""
    index = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        if page.stem != "index":
            assert re.search(rf"^{page.stem}$", index, re.MULTILINE), f"index.md: {page.stem} is missing"
            assert f"(docs/{page.name})" in readme, f"README.md: {page.name} is missing"
    for picture in (ROOT / "docs/gallery").iterdir():
        assert f"(docs/gallery/{picture.name})" in readme


def commands(page: Path) -> Iterator[tuple[str, list[str]]]:
    """Place and words of every command of strandcli or make on a page."""
    for block in blocks(page):
        if block.language not in ("", "bash", "console"):
            continue
        lines = block.text.replace("\\\n", " ").splitlines()
        for line in lines:
            found = re.match(r"(?:\S*/)?(strandcli|make) (?=[a-z-])(.*)", line)
            if found:
                yield block.place, [found[1], *words(found[2])]
    for found in re.finditer(r"`((?:strandcli|make) [a-z][^`]*)`", prose(page)):
        yield f"{page.name}: {found[1]}", words(found[1])


def words(text: str) -> list[str]:
    """A command line as the shell hands it on, up to what is piped, redirected or chained."""
    lexer = shlex.shlex(text.replace("…", ""), posix=True, punctuation_chars="|>;&")
    lexer.whitespace_split = True
    found: list[str] = []
    for word in lexer:
        if word[0] in "|>;&":
            break
        found.append(word)
    return found


def options_of(command: click.Command) -> set[str]:
    return {name for one in command.params for name in one.opts} | {"-h", "--help", "--debug"}


def wrong_in(command: Sequence[str]) -> str:
    """What a command line names that does not exist; "" where all does."""
    if command[0] == "make":
        targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
        named = [word for word in command[1:] if "=" not in word]
        return next((word for word in named if word not in targets), "")
    context = click.Context(cli)
    found: click.Command = cli
    for word in command[1:]:
        if isinstance(found, click.Group) and re.fullmatch(r"[a-z]+", word):
            inner = found.get_command(context, word)
            if inner is None:
                return word
            found = inner
        elif word.startswith("-") and word.partition("=")[0] not in options_of(found):
            return word
    return ""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_commands_and_options_exist(page: Path) -> None:
    wrong = [(place, missing) for place, command in commands(page) if (missing := wrong_in(command))]
    assert not wrong


def test_wrong_commands_are_found() -> None:
    assert wrong_in(["strandcli", "rendr", "hair"]) == "rendr"
    assert wrong_in(["strandcli", "render", "hair", "--no-such"]) == "--no-such"
    assert wrong_in(["strandcli", "golden", "chekc", "DIR"]) == "chekc"
    assert wrong_in(["make", "no-such"]) == "no-such"


def presets() -> list[Block]:
    return [
        block
        for page in PAGES
        for block in blocks(page)
        if block.language == "yaml" and block.above.strip() != NO_PRESET
    ]


@pytest.mark.parametrize("block", presets(), ids=lambda block: block.place)
def test_presets_load(block: Block, tmp_path: Path) -> None:
    path = tmp_path / "preset.yaml"
    path.write_text(block.text, encoding="utf-8")
    strandcli.load(str(path))


def test_the_readmes_python_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a scene of a few strands, of which one frame is drawn."""
    snippet = next(block.text for block in blocks(ROOT / "README.md") if block.language == "python")
    load, render = strandcli.load, strandcli.render
    small = {"emitter.strands": 20, "children.count": 2, "image.size": [40, 30], "time.preroll": 0.0}
    drawn: list[Any] = []

    def first(scene: Any, frames: Sequence[int]) -> Iterator[Any]:
        for frame in render(scene, frames=frames[:1]):
            drawn.append(frame)
            yield frame

    monkeypatch.setattr(strandcli, "load", lambda name, overrides: load(name, overrides, small))
    monkeypatch.setattr(strandcli, "render", first)
    exec(compile(snippet, "README.md", "exec"), {})
    assert [frame.number for frame in drawn] == [1]
    assert drawn[0].image.shape == (30, 40, 3)
    assert drawn[0].positions.shape == (20, 18, 3)
    assert drawn[0].aovs == {}


def test_the_table_of_qualities_is_theirs() -> None:
    """docs/presets.md has a row a setting, a column a quality; an empty cell is a dash."""
    page = (ROOT / "docs/presets.md").read_text(encoding="utf-8")
    table = re.search(r"\| key \| `draft` .*?\n\|[-|]+\n((?:\|.*\n)+)", page)
    rows = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in table[1].splitlines()]
    for column, quality in enumerate(("draft", "default", "best"), 1):
        told = {row[0]: row[column] for row in rows if row[column] != "–"}
        told = {path.replace("lights[]", "lights.*"): words for path, words in told.items()}
        assert told == {path: f"{value:g}" if isinstance(value, float) else str(value)
                        for path, value in QUALITIES[quality].items()}  # fmt: skip


def test_extending_shows_each_example_in_less_than_sixty_lines() -> None:
    """Examples are included from their files: whole, or between the lines that begin as the page says."""
    page = (ROOT / "docs/extending.md").read_text(encoding="utf-8")
    shown = re.findall(r"literalinclude\} \.\./(\S+)\n(?::language: python\n)?((?::.+\n)*)", page)
    assert shown
    for name, options in shown:
        text = (ROOT / name).read_text(encoding="utf-8")
        begin = re.search(r":start-at: (.+)", options)
        end = re.search(r":end-before: (.+)", options)
        first = text.index(begin[1]) if begin else 0
        last = text.index(f"\n{end[1]}") if end else len(text)
        assert f"`{name}`" in page
        assert len(text[first:last].splitlines()) < 60, name


def test_every_example_is_listed() -> None:
    readme = (ROOT / "examples/README.md").read_text(encoding="utf-8")
    for program in (ROOT / "examples").glob("*.py"):
        assert f"`{program.name}`" in readme, f"examples/README.md: {program.name} is missing"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_formulas_survive_plain_markdown(page: Path) -> None:
    """GitHub takes a backslash before punctuation, and a star, for Markdown's own, within formulas too."""
    formulas = re.findall(r"\$\$(.+?)\$\$|\$([^$\n]+)\$", prose(page), re.DOTALL)
    assert not [one for pair in formulas for one in pair if re.search(r"\\[,;:!{}%#&_*]|\*", one)]
