"""How `fuzz` damages files: bytes, words and blocks of any, values of JSON, archives with right checksums."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from copy import deepcopy
from typing import Any

import numpy as np

import mesh_kit

WORDS = (0, 1, 2, 0x7F, 0x80, 0xFF, 0xFFFF, 0x10000, 2**31 - 1, 2**31, 2**32 - 1, 0x7FC00000, 0x7F800000)


def mutated(content: bytes, generator: np.random.Generator) -> bytes:
    """A file that is damaged in one to four ways."""
    data = bytearray(content)
    for _ in range(generator.integers(1, 5)):
        size = len(data)
        begin = int(generator.integers(size + 1 if generator.random() < 0.7 else min(size, 200) + 1))
        match int(generator.integers(9)):
            case 0:
                del data[begin:]
            case 1:
                del data[begin : begin + int(generator.integers(1, 30))]
            case 2:
                data[begin:begin] = generator.bytes(int(generator.integers(1, 30)))
            case 3:
                data[begin : begin + 1] = generator.bytes(1)
            case 4:
                if begin < size:
                    data[begin] ^= 1 << int(generator.integers(8))
            case 5 | 6:
                at = begin - begin % 4
                data[at : at + 4] = struct.pack("<I", WORDS[int(generator.integers(len(WORDS)))])
            case 7:  # a number of a text
                digits = [place for place, byte in enumerate(data[:600]) if 48 <= byte <= 57]
                if digits:
                    at = digits[int(generator.integers(len(digits)))]
                    data[at : at + 1] = str(int(10.0 ** generator.uniform(0, 19))).encode()
            case _:
                other = int(generator.integers(size + 1))
                data[begin : begin + 16] = data[other : other + 16]
    return bytes(data)


OTHERS: tuple[object, ...] = (
    *WORDS, -1, -(10**20), 10**20, 10**400, float("inf"), float("nan"), 1.5, None, True, "", "x", [], [[]], [0], {},
    [{}], {"a": 0},
)  # fmt: skip
"""What values of a header become."""


def mutated_header(content: bytes, generator: np.random.Generator) -> bytes:
    """A glTF file, or JSON, in whose header up to three values are others."""
    packed = content[:4] == b"glTF"
    end = 20 + struct.unpack("<I", content[12:16])[0] if packed else len(content)
    tree = json.loads(content[20 if packed else 0 : end])
    for _ in range(generator.integers(1, 4)):
        place: Any = tree
        while True:
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            if not keys:
                break
            key = keys[int(generator.integers(len(keys)))]
            if isinstance(place[key], dict | list) and generator.random() < 0.85:
                place = place[key]
                continue
            place[key] = deepcopy(OTHERS[int(generator.integers(len(OTHERS)))])
            break
    return mesh_kit.glb(tree, content[end + 8 :]) if packed else json.dumps(tree).encode()


def checksums_right(content: bytes) -> bytes:
    """An archive whose members' checksums were made those of what they hold now, where that can be; so that what is
    damaged inside is read."""
    data = bytearray(content)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            directory = archive.start_dir
            for info in archive.infolist():
                with archive.open(info) as member:
                    member._expected_crc = None  # type: ignore[attr-defined]
                    crc = zipfile.crc32(member.read(1 << 20))  # type: ignore[attr-defined]
                place = data.index(b"PK\1\2", directory)
                data[place + 16 : place + 20] = struct.pack("<I", crc)
                directory = place + 46
    except Exception:  # whatever a damaged archive raises
        return content
    return bytes(data)


def mutated_json(content: bytes, generator: np.random.Generator) -> bytes:
    """JSON that is damaged anywhere, or, mostly, in its values."""
    return (mutated_header if generator.random() < 0.8 else mutated)(content, generator)


def mutated_archive(content: bytes, generator: np.random.Generator) -> bytes:
    """An archive, mostly with checksums that fit."""
    data = mutated(content, generator)
    return checksums_right(data) if generator.random() < 0.7 else data
