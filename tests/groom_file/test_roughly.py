"""What `plan` tells of strands of a file, which some of them stand for: the same words as of all."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import exchange_kit
from cli_runs import Runner
from groom_file_kit import hanging, write
from strandcli.groom_file import read

COUNT = 600


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(read, "ROUGHLY", 100)


def made(kind: str, folder: Path) -> Path:
    """A file of strands of some kind."""
    rng = np.random.default_rng(3)
    counts = rng.integers(3, 12, COUNT).tolist() if kind == "uneven" else [8] * COUNT
    strands = hanging(counts)
    if kind == "faults":  # at places that are not looked at
        strands[7], strands[13][2, 1] = strands[8], np.nan
        return write(folder / "a.data", [*strands, strands[0][:1]])
    flags, more = 0, b""
    if kind.startswith("width"):
        flags, more = 4, np.full(8 * COUNT, 1e3 if kind == "widths that are none" else 0.02, "<f4").tobytes()
    if kind.startswith("colour"):
        colours = np.full((COUNT, 3), 0.5, "<f4")
        colours[7] = (1, 0, 0) if kind == "colour of one strand" else colours[7]
        flags, more = 16, np.repeat(colours, 8, axis=0).tobytes()
    if not flags:
        return write(folder / "a.data", strands)
    path = folder / "a.hair"
    path.write_bytes(exchange_kit.hair(strands, more=more, flags=flags))
    return path


KINDS = ("even", "uneven", "faults", "widths", "widths that are none", "colour of one strand", "colours that are one")


@pytest.mark.parametrize("kind", KINDS)
def test_plan_says_the_same(kind: str, tmp_path: Path, run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    # free memory changes from one run to the next, and seconds follow from sizes that are rough
    monkeypatch.setattr("strandcli.plan.limits.available_memory", lambda: 8_000_000_000)
    monkeypatch.setattr("strandcli.calibration.read", lambda: None)
    path = made(kind, tmp_path)
    some = run("plan", path)
    monkeypatch.setattr(read, "ROUGHLY", COUNT)
    path.touch()
    whole = run("plan", path)
    (few, some_words), (all_of_them, whole_words) = without_memory(some.out), without_memory(whole.out)
    assert (some.code, some_words, some.err) == (0, whole_words, whole.err)
    assert "strands, " in some.out
    assert few == pytest.approx(all_of_them, abs=1)  # of sizes that are rough, to the nearest


def without_memory(words: str) -> tuple[int, str]:
    """The megabytes that a plan tells, and its words without them."""
    (found,) = re.findall(r"about (\d+) MB of memory", words)
    return int(found), words.replace(f"about {found} MB", "about so many MB")
