"""States as files: what was written is read, to the bit; whatever else is there is refused, and takes no memory."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strandcli.output.state_file import MAGIC, DamagedError, ForeignError, read_state, write_state

KEY, OTHER = "a" * 64, "b" * 64
ARRAYS = {"clock": np.array([3.0]), "rows": np.arange(24, dtype=np.float32).reshape(2, 3, 4)}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    found = tmp_path / "frame_0003.state"
    write_state(found, KEY, ARRAYS)
    return found


def test_free_arrays_are_as_long_as_the_file_says_and_no_longer_than_it_is(tmp_path: Path) -> None:
    path = tmp_path / "free"
    kept = {"free pressure": np.arange(5, dtype=np.float32), "clock": np.array([1.0])}
    write_state(path, KEY, kept)
    asked = {"free pressure": np.zeros(0, np.float32), "clock": np.zeros(1)}
    np.testing.assert_array_equal(read_state(path, KEY, asked)["free pressure"], kept["free pressure"])
    whole = path.read_bytes()
    for length in (b"999999999999999", b"-5", b"true", b"[5]", b"4"):
        path.write_bytes(whole.replace(b"[5]", b"[" + length + b"]", 1))
        with pytest.raises((DamagedError, ForeignError)):
            read_state(path, KEY, asked)


def test_another_key_or_shape_or_type_is_foreign(path: Path) -> None:
    with pytest.raises(ForeignError):
        read_state(path, OTHER, ARRAYS)
    with pytest.raises(ForeignError):
        read_state(path, KEY, ARRAYS | {"rows": np.zeros((2, 3, 5), np.float32)})
    with pytest.raises(ForeignError):
        read_state(path, KEY, ARRAYS | {"rows": np.zeros((2, 3, 4))})
    with pytest.raises(ForeignError):
        read_state(path, KEY, {"clock": ARRAYS["clock"]})


def test_every_bit_counts(path: Path) -> None:
    """Any bit that has fallen over anywhere makes a file damaged, or of something else; none is read."""
    whole = path.read_bytes()
    for place in range(len(whole)):
        data = bytearray(whole)
        data[place] ^= 1 << place % 8
        path.write_bytes(data)
        with pytest.raises((DamagedError, ForeignError)):
            read_state(path, KEY, ARRAYS)


@given(st.data())
def test_lengths_and_rubbish(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    path = tmp_path_factory.mktemp("state") / "frame_0003.state"
    write_state(path, KEY, ARRAYS)
    whole = path.read_bytes()
    cut = data.draw(st.integers(0, len(whole) - 1))
    path.write_bytes(whole[:cut] if data.draw(st.booleans()) else whole[:cut] + data.draw(st.binary(max_size=99)))
    if path.read_bytes() != whole:
        with pytest.raises((DamagedError, ForeignError)):
            read_state(path, KEY, ARRAYS)
    path.write_bytes(whole + b"\0")
    with pytest.raises(DamagedError):
        read_state(path, KEY, ARRAYS)


def test_neither_pipes_nor_folders_nor_deep_heads_are_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "deep").write_bytes(MAGIC + b"[" * 60_000 + b"\n")
    (tmp_path / "wide").write_bytes(
        MAGIC + json.dumps({"key": KEY, "arrays": [["rows", "<f8", [1 << 60]]]}).encode() + b"\n"
    )
    for name, error in (("pipe", DamagedError), ("folder", OSError), ("deep", DamagedError), ("wide", DamagedError)):
        with pytest.raises(error):
            read_state(tmp_path / name, KEY, ARRAYS)
