"""Files whose size is known before anything is read: no count is believed before the bytes for it are there; what such
a file may name beside itself; and arrays of which the length is not known."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NoReturn
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from ..errors import StrandError, UsageError, one_line
from ..files import inputs
from ..files.picture_samples import pixels
from .strands import CHUNK

TIMES, SPARE = 3, 90_000_000
"""Memory that what is read may take: so many times the file, and so many bytes."""
SLICE = 1 << 22
"""Bytes that are converted at once."""

LONGEST = 400
"""Letters of a message, which may name what a damaged file names."""


class Bounded:
    """A file that is read from its begin to its end, field by field.

    Every method that reads raises `UsageError`, which names the field and its byte, where the bytes are not there.
    """

    def __init__(self, path: Path, file: BinaryIO, size: int, what: str, lenient: bool = False) -> None:
        """``what``: what the file should be, for messages; ``lenient``: NaN and infinity are let in."""
        self.path, self.file, self.size, self.what, self.lenient = path, file, size, what, lenient
        self.position = 0

    @property
    def left(self) -> int:
        """Bytes that were not read yet."""
        return self.size - self.position

    def fault(self, message: str, at: int | None = None) -> UsageError:
        """An error that says at which byte."""
        return UsageError(f"{self.path}: byte {self.position if at is None else at:,}: {shortened(message)}")

    def damaged(self, message: str, at: int | None = None) -> UsageError:
        """An error of a file that does not agree with itself."""
        return self.fault(f"{message}; it is damaged or no {self.what}", at)

    def need(self, field: str, count: int, each: int, at: int | None = None) -> None:
        """Raise where ``count`` items of ``each`` bytes do not fit what is left; ``at``: the byte of the count."""
        if count < 0:
            raise self.damaged(f"{field}: {count:,} cannot be", at)
        if count * each > self.left:
            needs, left = amount(count * each), amount(self.left)
            raise self.damaged(f"{field}: {count:,} need {needs}, the file has {left} there", at)

    def room(self, field: str, count: int, each: int) -> None:
        """Raise where ``count`` items of ``each`` bytes in memory take far more than the file: few bytes may name the
        same things again and again."""
        why = too_many(field, count, each, self.size)
        if why:
            raise self.damaged(why, 0)

    def seek(self, field: str, position: int, at: int | None = None) -> None:
        """Go on reading at a byte that the file itself names."""
        if not 0 <= position <= self.size:
            raise self.damaged(f"{field}: begins at byte {position:,}, the file has {amount(self.size)}", at)
        self.file.seek(position)
        self.position = position

    def take(self, field: str, count: int) -> bytes:
        """The next ``count`` bytes."""
        if count > self.left:
            raise self.damaged(f"{field}: needs {amount(count)}, the file has {amount(self.left)} there")
        data = self.file.read(count)
        if len(data) != count:
            self._shrunk()
        self.position += count
        return data

    def line(self, field: str, longest: int = 4096) -> bytes:
        """The next bytes up to the end of a line, without it."""
        data = self.file.readline(min(longest, self.left))
        if not data.endswith(b"\n"):
            raise self.damaged(f"{field}: no end of line within {min(longest, self.left):,} bytes")
        self.position += len(data)
        return data.rstrip(b"\r\n")

    def blocks(self, what: str, size: int, longest: int, end_in: Callable[[bytes], int]) -> Iterator[bytes]:
        """The rest of a text, some bytes at once, each up to a place that ``end_in`` finds in it; ``what`` ends there,
        and has ``longest`` bytes at most."""
        rest = b""
        while self.left:
            content = rest + self.take(what, min(size, self.left))
            end = end_in(content) if self.left else len(content)
            rest = content[end:]
            if len(rest) > longest:
                raise self.damaged(f"no end of {what} within {longest:,} bytes")
            yield content[:end]

    def array(self, field: str, dtype: npt.DTypeLike, shape: tuple[int, ...], at: int | None = None) -> Any:
        """The next numbers, as an array of a shape; ``at``: the byte of the count that it comes from."""
        kind = np.dtype(dtype)
        self.need(field, shape[0], kind.itemsize * math.prod(shape[1:]), at)
        values = np.empty(shape, kind)
        self.fill(values.reshape(-1).view(np.uint8).data)
        return values

    def fill(self, view: memoryview) -> None:
        """The next bytes into memory, of which there are enough."""
        done = 0
        while done < len(view):
            got = self.file.readinto(view[done:])  # type: ignore[attr-defined]
            if not got:
                self._shrunk()
            done += got
        self.position += done

    def finite(self, field: str, values: npt.NDArray[Any], byte: Callable[[int], int]) -> None:
        """Raise where a number is not finite, unless that is allowed; ``byte``: of a row its place in the file."""
        row, why = (0, "") if self.lenient else not_finite_words(field, values)
        if why:
            raise self.fault(why, byte(row))

    def end(self) -> None:
        """Raise where something follows."""
        if self.left:
            raise self.damaged(f"{amount(self.left)} after what the header declares")

    def _shrunk(self) -> NoReturn:
        raise UsageError(f"{self.path}: became shorter while it was read; read it again when it is written")


@contextmanager
def opened(path: Path, what: str, lenient: bool = False) -> Iterator[Bounded]:
    """A file to be read; arguments as for `Bounded`. Raises as `strandcli.files.inputs.opened`."""
    with inputs.opened(path) as file:
        yield Bounded(path, file, os.fstat(file.fileno()).st_size, what, lenient)


def numbers_of(text: bytes) -> npt.NDArray[np.float64] | None:
    """The numbers of a text, between blanks; None where it has anything else."""
    with warnings.catch_warnings(), np.errstate(over="ignore"):
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, np.float64, sep=" ") if text.strip() else np.zeros(0)
        except (ValueError, DeprecationWarning):
            return None


def too_many(field: str, count: int, each: int, size: int) -> str | None:
    """What is wrong with ``count`` items of ``each`` bytes in memory, of a file of ``size`` bytes; None where there is
    room for them."""
    if count * each <= TIMES * size + SPARE:
        return None
    return f"{field}: {count:,} take {amount(count * each)} of memory, of a file of {amount(size)}"


def not_finite(values: npt.NDArray[Any]) -> tuple[int, int]:
    """How many rows of an array have a number that is NaN or infinite, and the first of them; -1 of none."""
    count, first = 0, -1
    for begin in range(0, values.shape[0] if values.dtype.kind == "f" else 0, CHUNK):
        part = values[begin : begin + CHUNK]
        fine = np.isfinite(part)
        if not fine.all():
            wrong = ~fine.reshape(part.shape[0], -1).all(axis=1)
            first = first if count else begin + int(np.argmax(wrong))
            count += int(np.count_nonzero(wrong))
    return count, first


def not_finite_words(field: str, values: npt.NDArray[Any]) -> tuple[int, str]:
    """The first row with a number that is NaN or infinite, and what is to be said of all such; "" of none."""
    count, row = not_finite(values)
    more = f", and {count - 1:,} more" if count > 1 else ""
    return row, f"{field}: number {row:,} is not finite{more}; 'convert --fix' mends it" if count else ""


def shortened(message: str) -> str:
    """A message in a line, without its middle where it is long."""
    words = one_line(message)
    return words if len(words) <= LONGEST else f"{words[: LONGEST // 2]} … {words[-LONGEST // 2 :]}"


def amount(count: int) -> str:
    """Bytes for people."""
    for unit, size in (("EB", 1e18), ("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:,.3g} {unit}" if count < 1000 * size else f"{count / size:,.0f} {unit}"
    return counted(count, "byte")


FIRST, SHARE = 1 << 12, 8
"""Rows that there is room for at first; and as many more as this share of them where it ends."""


class Growing:
    """Rows of an array to which more are added. It grows in its place, so that memory never holds it twice."""

    def __init__(self, kind: npt.DTypeLike, *shape: int) -> None:
        """``shape``: of a row."""
        self._rows: npt.NDArray[Any] = np.empty((FIRST, *shape), kind)
        self.size = 0

    def add(self, rows: npt.ArrayLike) -> None:
        """Append rows."""
        more = np.asarray(rows)
        end = self.size + len(more)
        if end > len(self._rows):
            self._resize(end + end // SHARE)
        self._rows[self.size : end] = more
        self.size = end

    @property
    def rows(self) -> npt.NDArray[Any]:
        """The rows so far, valid until more are added."""
        return self._rows[: self.size]

    def taken(self) -> npt.NDArray[Any]:
        """All rows, of which none may be added afterwards."""
        self._resize(self.size)
        return self._rows

    def _resize(self, rows: int) -> None:
        self._rows.resize((rows, *self._rows.shape[1:]), refcheck=False)


LARGEST = 1 << 31
"""Bytes of a file that another one names, at most."""


class Beside:
    """Files beside a file, each read once; nothing from elsewhere and nothing from the net."""

    def __init__(self, path: Path) -> None:
        self.folder = path.parent.resolve()
        self.missing: list[str] = []
        self.unread: list[str] = []
        """Pictures that could not be read."""
        self._contents: dict[Path, bytearray] = {}

    def get(self, name: str) -> bytearray:
        """What a file holds. Raises `ValueError` for one outside of the folder, `OSError` for none."""
        try:
            path = (self.folder / unquote(name.strip()).replace("\\", "/")).resolve()
            if not path.is_relative_to(self.folder):
                raise ValueError("outside of the folder")
            if path not in self._contents:
                self._contents[path] = self._read(path)
            return self._contents[path]
        except (OSError, ValueError):
            self.missing.append(name[:80])
            raise

    def picture(self, name: str) -> npt.NDArray[np.uint8] | None:
        """The pixels (h, w, 3) of a picture; None where there is none that can be read."""
        try:
            content = self.get(name)
        except (OSError, ValueError):
            return None
        try:
            return pixels(bytes(content))
        except ValueError:
            self.unread.append(name[:80])
            return None

    def _read(self, path: Path) -> bytearray:
        try:
            with opened(path, "file") as file:
                if file.size > LARGEST:
                    raise ValueError("too large")
                return _content(file)
        except StrandError as error:
            raise OSError(str(error)) from None

    @property
    def size(self) -> int:
        """Bytes of the files that were read."""
        return sum(map(len, self._contents.values()))


def whole(path: Path, what: str) -> bytearray:
    """What a file holds; arrays of it can be written to."""
    with opened(path, what) as file:
        return _content(file)


def _content(file: Bounded) -> bytearray:
    found = bytearray(file.size)
    file.fill(memoryview(found))
    return found
