"""STL: text however it is laid out against trimesh, binary whatever its header tells, and what is damaged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mesh_kit as kit
from strandcli.errors import UsageError
from strandcli.exchange.bounded import Beside
from strandcli.meshes import stl

BALL = kit.mesh("ball")
CORNERS = BALL.vertices[BALL.triangles]
FACET = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\n"
NUMBERS = st.floats(-1e9, 1e9, allow_subnormal=False)
BLANKS = st.sampled_from([" ", "\t", "  ", " \t ", "\v"])
ENDS = st.sampled_from(["\n", "\r\n", "\r", "\n\n \n"])
NAMES = st.sampled_from(["", " a", " My Part-3 (left)", " solid", " of facets", " vertex 1 2", " \xfc", " ENDSOLID"])


def read(path: Path, content: bytes) -> np.ndarray:
    """Corners (T, 3, 3) of a file."""
    path.write_bytes(content)
    parts = stl.read_stl(path, Beside(path))
    return parts[0].vertices[parts[0].triangles] if parts else np.zeros((0, 3, 3))


@st.composite
def texts(draw: st.DrawFn) -> tuple[str, np.ndarray]:
    """A text of some solids, laid out by chance, and its corners."""
    corners, words = [], []
    blank, end = draw(BLANKS), draw(ENDS)
    change = draw(st.sampled_from([str, str.upper, str.title]))
    form = draw(st.sampled_from(["{!r}", "{:.17e}", "{:+.17E}"]))
    for facets in draw(st.lists(st.integers(0, 4), min_size=1, max_size=3)):
        words.append(change("solid") + draw(NAMES))
        for _ in range(facets):
            triangle = draw(st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), min_size=3, max_size=3))
            corners.append(triangle)
            normal = draw(st.sampled_from(["0 0 1", "nan nan nan", "-1.#IND 0 1"]))
            vertices = [
                change(f"vertex{blank}") + blank.join(form.format(float(x)) for x in point) for point in triangle
            ]
            rows = [f"facet normal {normal}", f"outer{blank}loop", *vertices, "endloop", "endfacet"]
            words += [change(row) if row not in vertices else row for row in rows]
        words.append(change("endsolid") + draw(NAMES))
    return end.join(words) + draw(st.sampled_from(["", end])), np.array(corners, np.float64).reshape(-1, 3, 3)


@given(texts(), st.integers(1, 400))
def test_text_in_any_layout(tmp_path_factory: pytest.TempPathFactory, text: tuple[str, np.ndarray], block: int) -> None:
    path = tmp_path_factory.mktemp("stl") / "a.stl"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stl, "BLOCK", block)
        found = read(path, text[0].encode())
    np.testing.assert_array_equal(found, text[1])


def test_text_on_one_line_and_behind_a_mark(tmp_path: Path) -> None:
    words = " ".join(f"solid facet part {FACET} endsolid facet part solid b {FACET} endsolid b".split())
    assert read(tmp_path / "a.stl", words.encode()).shape == (2, 3, 3)
    assert read(tmp_path / "b.stl", b"\xef\xbb\xbf \n" + words.encode()).shape == (2, 3, 3)


@pytest.mark.parametrize("begin", [b"", b"solid a facet normal 0 0 1", b"solid a\n" + FACET.encode()[:60]])
def test_binary_is_known_by_its_size(begin: bytes, tmp_path: Path) -> None:
    content = begin[:80] + kit.stl(BALL)[len(begin[:80]) :]
    np.testing.assert_array_equal(read(tmp_path / "a.stl", content), CORNERS.astype(np.float32))
    for wrong in (content[:-3], content + b"\0", content[: stl.HEADER - 1]):
        with pytest.raises(UsageError, match=r"bytes, where [\d,]+ triangles, as its header declares, have [\d,]+"):
            read(tmp_path / "a.stl", wrong)


SOLID = f"solid a\n{FACET}{FACET}endsolid a\n"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (SOLID.replace("1 0 0", "1 0 x", 1), "line 2: no whole facet begins with 'facet'"),
        (SOLID.replace("1 0 0", "1 nan 0", 1), "line 2: no whole facet"),
        (SOLID.replace("1 0 0", "1 0", 1), "line 2: no whole facet"),
        (SOLID.replace("endfacet\nendsolid", "endsolid"), "line 9: no whole facet"),
        (SOLID.replace("endsolid a\n", ""), "line 16: ends without 'endsolid'"),
        (SOLID.replace("\n", "\r").replace("1 0 0", "x 0 0", 1), "line 2: no whole facet"),
        (SOLID + "\x1b[31m", r"line 17: no whole facet begins with '\x1b[31m'"),
        ("solid a\nendsolid a\n" + "x" * (1 << 20), "no end of a facet within"),
        ("x" + SOLID, "is no text that begins with 'solid'"), ("", "is no text that begins with 'solid'"),
    ],
)  # fmt: skip
def test_damaged_texts_are_told(content: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    with pytest.raises(UsageError) as told:
        read(path, content.encode())
    assert words in str(told.value)
    assert str(told.value).isprintable()
    assert len(str(told.value)) - len(str(path)) < 300


def test_a_line_is_that_of_the_file_in_any_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stl, "BLOCK", 100)
    content = f"solid a\n{FACET * 40}{FACET.replace('1 0 0', '1 0 x')}{FACET * 40}endsolid a\n"
    with pytest.raises(UsageError, match=f"line {2 + 7 * 40}: no whole facet"):
        read(tmp_path / "a.stl", content.encode())


@pytest.mark.parametrize("words", ["solid\n", "endfacet ", "endloop ", "endloop endfacet\n", "facet normal 0 0 1\n"])
def test_words_again_and_again_take_no_time(words: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError):
        read(tmp_path / "a.stl", b"solid a\n" + words.encode() * 100_000)
