"""Reports in HTML: whole, small, escaped, and with what the run has told."""

from __future__ import annotations

import base64
import io
import json
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from cli_runs import Runner
from strandcli.errors import UsageError
from strandcli.html_report import page, pictures, run
from strandcli.output.animation import write_animation
from strandcli.output.compare import write_image
from strandcli.output.files import require_own
from strandcli.output.png import GREY
from strandcli.run import pipeline

MOST_BYTES = 2_000_000
VOID = {"meta", "img", "br"}


class Read(HTMLParser):
    """The tags of a page, checked to be closed in order, its text, and its pictures' addresses."""

    def __init__(self, data: bytes) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.words: list[str] = []
        self.sources: list[str] = []
        self.attributes: set[str] = set()
        self.feed(data.decode())
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes |= {name for name, _ in attrs}
        self.sources += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def own(read: Read) -> None:
    """Nothing from elsewhere, no script."""
    assert "script" not in read.tags
    assert not [name for name in read.attributes if name.startswith("on")]
    assert all(source.startswith("data:image/") for source in read.sources)


def entry(frame: int, value: float = 0.5) -> dict[str, Any]:
    return {
        "frame": frame, "file": f"frame_{frame:04d}.png", "seconds": {"simulate": 0.01, "shade": value, "total": 0.6},
        "counts": {"strands": 10}, "error": {"stretch_max": 1e-3 * value, "residual_max": None},
    }  # fmt: skip


def report(frames: int = 3, **more: Any) -> dict[str, Any]:
    return {
        "strandcli": "0", "status": "complete", "preset": {"name": "hair", "sha256": "ab"}, "scene": "cd",
        "machine": {"cpu": "some"}, "plan": {"used": [], "left_out": [{"stage": "haze", "why": "the preset has none"}]},
        "compile_seconds": 0.0, "frames": [entry(frame) for frame in range(1, frames + 1)],
        "totals": {"seconds": 3.0, "peak_rss_bytes": 10**8}, **more,
    }  # fmt: skip


@given(words=st.text(max_size=40), lines=st.text(max_size=80))
def test_no_text_gets_out_of_its_place(words: str, lines: str) -> None:
    data = report(1, warnings=[words, f"</li><script>{words}"], failure={"message": words})
    data["preset"]["name"] = f'"><img src=x onerror="{words}'
    data["plan"]["used"] = [{"stage": words, "why": f"<svg onload={words}>"}]
    data["frames"][0]["file"] = words.replace("\0", "")
    read = Read(page.page(words, run.parts(Path("/nowhere"), data, lines, [])))
    own(read)
    assert "img" not in read.tags
    assert page.text(words).isprintable()


def test_a_run_of_thousands_of_frames_stays_small_and_shows_its_worst(tmp_path: Path) -> None:
    """Pictures are noise, the worst case for their size; one frame of 5,000 is far off, and is seen in the line."""
    noise = np.random.default_rng(1).integers(0, 256, (600, 800, 3), dtype=np.uint8)
    data = report(5000)
    data["frames"][3210]["error"]["stretch_max"] = 0.4
    data["warnings"] = ["a long warning " * 20] * 40
    for one in pictures.chosen(data["frames"], run.SHEET):
        write_image(tmp_path / one["file"], noise)
    film = tmp_path / "animation.webp"
    Image.fromarray(noise).save(film, save_all=True, append_images=[Image.fromarray(noise[::-1])] * 9, quality=95)
    assert film.stat().st_size > pictures.FILM_BYTES
    path = run.write(tmp_path, data, "x: 1\n" * 100_000, [film])
    content = path.read_bytes()
    assert len(content) < MOST_BYTES
    read = Read(content)
    own(read)
    assert len(read.sources) == run.SHEET + 1
    assert read.sources[0].startswith("data:image/webp")
    assert "50 %" in read.words, "the top of the scale of 40 % of stretch"
    assert "haze" in read.words


def test_lines_keep_peaks_and_bars_their_shares() -> None:
    points = [(float(x), 1.0) for x in range(10_000)]
    points[4321] = (4321.0, 9.0)
    assert (4321.0, 9.0) in page.thinned(points)
    assert len(page.thinned(points)) <= page.MOST_POINTS
    chart = ET.fromstring(page.line(points, " ms"))
    line = chart.find("polyline")
    heights = [float(pair.split(",")[1]) for pair in line.attrib["points"].split()]
    assert min(heights) == pytest.approx(page.TOP + (page.HEIGHT - page.BOTTOM - page.TOP) * 0.1)
    bars = ET.fromstring(page.bars([("one", 4.0, "<"), ("two", 1.0, "&")]))
    widths = [float(one.attrib["width"]) for one in bars.findall("rect")]
    assert widths[0] == pytest.approx(4 * widths[1], rel=1e-3)
    assert page.line([], "") == page.bars([]) == ""
    assert [page._round_up(value) for value in (0, 0.7, 1, 1.1, 30, 51)] == [1, 1, 1, 2, 50, 100]


def test_a_small_animation_is_kept_and_what_cannot_be_read_is_left_out(tmp_path: Path) -> None:
    frames = []
    for number in (1, 2):
        frames.append(tmp_path / f"frame_{number:04d}.png")
        write_image(frames[-1], np.full((30, 40, 3), 90 * number, np.uint8))
    write_animation(tmp_path / "a.gif", frames, [1, 2], 24.0)
    film = pictures.film(tmp_path / "a.gif")
    assert film.size == (tmp_path / "a.gif").stat().st_size
    (tmp_path / "b.gif").write_bytes(b"GIF89a")
    assert pictures.film(tmp_path / "b.gif") is None
    assert pictures.embedded(tmp_path / "none.png", 100, 1000) is None
    assert pictures.chosen(list(range(100)), 3) == [0, 50, 99]
    write_image(frames[0], np.full((30, 40, 4), (250, 0, 0, 0), np.uint8))  # red, and nothing of it to be seen
    bare = pictures.embedded(frames[0], 100, 100_000)
    with Image.open(io.BytesIO(base64.b64decode(bare.address.partition(",")[2]))) as image:
        assert np.abs(np.asarray(image).astype(int) - GREY).max() <= 2


def test_each_run_ends_in_a_page(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run("render", "tiny.yaml", "-f", "1-3", "-o", "out", "--animate", "gif", "-q").code == 0
    read = Read(Path("out/report.html").read_bytes())
    own(read)
    assert len(read.sources) == 4
    words = " ".join(read.words)
    data = json.loads(Path("out/report.json").read_text())
    for word in ("complete", "3 frames, 1 to 3", "title: a few strands for tests", data["machine"]["numba"],
                 *(one["stage"] for one in data["plan"]["left_out"])):  # fmt: skip
        assert word in words
    assert run("render", "tiny.yaml", "-f", "4", "-o", "none", "--no-html", "-q").code == 0
    assert not Path("none/report.html").exists()

    def stops(*given: Any, **options: Any) -> Any:
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(pipeline, "render", stops)
    assert run("render", "tiny.yaml", "-f", "5", "-o", "out", "-q").code == 130
    assert "interrupted" in Read(Path("out/report.html").read_bytes()).words


def test_somebody_elses_page_stays(run: Runner) -> None:
    Path("out").mkdir()
    Path("out/report.html").write_text("<html>mine")
    assert "was not written by strandcli" in run.refused("render", "tiny.yaml", "-f", "1", "-o", "out")
    assert Path("out/report.html").read_text() == "<html>mine"
    assert not Path("out/frame_0001.png").exists()
    with pytest.raises(UsageError):
        require_own(Path("out"), page.is_report)
