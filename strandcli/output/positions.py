"""Positions of a run as ``positions_0001.npz`` … with ``manifest.json``, written by ``simulate`` and read again by
``render --from-cache``: the array ``positions``, float32, shape (strands, particles, 3), world units (metres)."""

from __future__ import annotations

import hashlib
import json
import warnings
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import __version__
from ..errors import RefusedError, UsageError, said
from ..files.inputs import opened, unrecorded
from .claim import Claim
from .files import ARCHIVE_ERRORS, prepare_folder, read_json, refuse_present, require_own, with_whole, write_json
from .report import finite
from .state_file import made_of, write_array

Positions = npt.NDArray[np.float32]


class Motion(NamedTuple):
    """What positions follow from."""

    fingerprint: str
    """Hash of that, and of the version of strandcli; empty where not known."""
    settings: dict[str, Any]
    """All settings that move strands, as `strandcli.run.fingerprint.motion_values` has them."""


MANIFEST, ARRAY = "manifest.json", "positions"
SCHEMA_VERSION = 1
AGAIN = "run 'strandcli simulate' again with --overwrite"


def positions_file(frame: int) -> str:
    """The file name of one frame's positions."""
    return f"positions_{frame:04d}.npz"


class PositionsWriter:
    """Writes one compressionless .npz a frame, and at the end the manifest of all of them."""

    def __init__(
        self, directory: Path, frames: Sequence[int], strands: int, particles: int, *,
        overwrite: bool, resume: bool, motion: Motion | None = None,
    ) -> None:  # fmt: skip
        """Refuses up front as `FrameWriter` does. With ``resume``, files that are whole and of this ``motion`` stay."""
        self.directory = directory
        self.shape = (strands, particles, 3)
        self.motion = motion or Motion("", {})
        self.earlier = [f for f in frames if resume and self._whole(directory / positions_file(f))]
        there = [positions_file(f) for f in frames if (directory / positions_file(f)).exists()]
        if not overwrite:
            refuse_present(directory, [] if resume else there)
            require_own(directory / MANIFEST)
        self.wanted = tuple(f for f in frames if f not in self.earlier)
        self.done = list(self.earlier)
        self.errors = _known_errors(directory, self.earlier)
        prepare_folder(directory, len(self.wanted) * (strands * particles * 12 + 512))
        self._claim = Claim(directory, "positions")

    @unrecorded()
    def _whole(self, path: Path) -> bool:
        """Whether a file is whole; raises ``UsageError`` for one of another motion."""
        try:
            with opened(path) as file, zipfile.ZipFile(file) as archive:
                of = made_of(archive)
        except (UsageError, RefusedError, *ARCHIVE_ERRORS):
            return False
        if of != self.motion.fingerprint:
            raise UsageError(
                f"{path}: was simulated from another scene or with other settings, so --resume would mix two motions; "
                f"empty {self.directory}, add --overwrite instead, or choose another folder with -o"
            )
        try:
            read_positions(path, self.shape)
        except UsageError:
            return False
        return True

    def write(self, frame: int, positions: Positions, error: Mapping[str, Any] | None = None) -> None:
        """Write one frame's positions, whole or not at all. ``error``: the frame's errors, as in report.json, for the
        manifest."""
        try:
            array = np.asarray(positions, np.float32)
            write_array(self.directory / positions_file(frame), ARRAY, array, self.motion.fingerprint)
        except RefusedError as error:
            raise with_whole(error, (self.directory / positions_file(one) for one in self.done)) from error
        self.done.append(frame)
        if error is not None:
            self.errors[frame] = finite(error)

    def write_manifest(self, preset: str, sha256: str | None, fps: float, status: str) -> dict[str, Any]:
        """Write the manifest of the frames that are there, and let go of the folder; returns the manifest."""
        data = {
            "schema_version": SCHEMA_VERSION, "strandcli": __version__, "status": status,
            "preset": {"name": preset, "sha256": sha256 or None}, "strands": self.shape[0],
            "particles": self.shape[1], "dtype": "float32", "unit": "m", "fps": fps,
            **({"motion": self.motion._asdict()} if self.motion.fingerprint else {}),
            "frames": [self._entry(frame) for frame in sorted(self.done)],
        }  # fmt: skip
        try:
            write_json(self.directory / MANIFEST, data)
        finally:
            self._claim.release()
        return data

    def _entry(self, frame: int) -> dict[str, Any]:
        entry = {"frame": frame, "file": positions_file(frame)}
        return {**entry, "error": self.errors[frame]} if frame in self.errors else entry


def _known_errors(directory: Path, frames: Sequence[int]) -> dict[int, dict[str, Any]]:
    """What the manifest of a folder says of the errors of frames; none where there is no manifest to be read."""
    if not frames:
        return {}
    try:
        entries = _read_manifest(directory)["frames"]
    except (UsageError, RefusedError):
        return {}
    return {one["frame"]: one["error"] for one in entries if one["frame"] in frames and "error" in one}


def cached_frames(directory: Path) -> tuple[int, ...]:
    """The frames whose positions a folder has, ascending; ``UsageError`` where it is none of `simulate`."""
    entries = _read_manifest(directory)["frames"]
    return tuple(sorted({entry["frame"] for entry in entries if (directory / entry["file"]).is_file()}))


class PositionCache:
    """Positions to draw instead of simulating. Calling it with a frame number gives that frame's array."""

    def __init__(
        self, directory: Path, frames: Sequence[int], strands: int, particles: int, *, finite: bool = True
    ) -> None:
        """Check that the folder holds every frame, of the right shape and type, before anything is drawn.

        Raises ``UsageError`` that names what is missing or wrong; NaN and infinity are wrong where ``finite``.
        """
        self.directory = directory
        self.finite = finite
        self.shape = (strands, particles, 3)
        manifest = _read_manifest(directory)
        files = {entry["frame"]: entry["file"] for entry in manifest["frames"]}
        missing = [f for f in frames if f not in files or not (directory / files[f]).is_file()]
        if missing:
            listed = ", ".join(str(f) for f in missing[:10]) + (" …" if len(missing) > 10 else "")
            raise UsageError(
                f"{directory}: has no positions for {'frame' if len(missing) == 1 else 'frames'} {listed}; "
                "simulate them first, or ask for other frames with -f"
            )
        self.files = {f: directory / files[f] for f in frames}
        self.motion = _motion_of(manifest)
        """That the manifest lists; None where it is of an earlier version, or of another program."""
        self.digest = hashlib.sha256(json.dumps(manifest, sort_keys=True).encode()).hexdigest()
        for path in self.files.values():
            _check_header(path, self.shape, self.motion and self.motion.fingerprint)

    def __call__(self, frame: int) -> Positions:
        return read_positions(self.files[frame], self.shape, self.finite)


def read_positions(path: Path, shape: tuple[int, int, int], finite: bool = True) -> Positions:
    """The array of one file; ``UsageError`` for anything but float32 numbers of exactly this shape, finite ones
    unless that does not matter."""
    _check_header(path, shape)
    try:
        with opened(path) as file, np.load(file, allow_pickle=False) as data:
            positions: Positions = data["positions"]
    except (*ARCHIVE_ERRORS, KeyError) as error:
        raise UsageError(f"{path}: cannot be read: {_words(error)}; {AGAIN}") from None
    bad = ~np.isfinite(positions).all(axis=(1, 2))
    if finite and bad.any():
        more = f" ({int(bad.sum())} such strands)" if bad.sum() > 1 else ""
        raise UsageError(
            f"{path}: positions of strand {int(np.argmax(bad))} are not finite{more}; "
            "simulate them anew, or draw the rest with --keep-going"
        )
    return positions


def _motion_of(manifest: Mapping[str, Any]) -> Motion | None:
    found = manifest.get("motion")
    if not isinstance(found, dict) or not isinstance(found.get("settings"), dict):
        return None
    return Motion(str(found.get("fingerprint", "")), found["settings"])


def _check_header(path: Path, shape: tuple[int, int, int], motion: str | None = None) -> None:
    """Look at shape, type, and fingerprint of the motion, before any memory is taken on the file's word."""
    try:
        with opened(path) as file, zipfile.ZipFile(file) as archive, archive.open(f"{ARRAY}.npy") as member:
            if motion and made_of(archive) != motion:
                raise UsageError(f"{path}: is of another motion than {MANIFEST} lists; {AGAIN}")
            version = np.lib.format.read_magic(member)
            header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
            with warnings.catch_warnings(action="error"):  # a header of another program
                found, _, dtype = header(member)
    except KeyError:
        raise UsageError(f"{path}: has no array named 'positions'; {AGAIN}") from None
    except (*ARCHIVE_ERRORS, UserWarning) as error:
        raise UsageError(f"{path}: not a file of positions: {_words(error)}; {AGAIN}") from None
    if tuple(found) != shape:
        strands, particles, _ = shape
        raise UsageError(
            f"{path}: positions have shape {tuple(found)}, but the scene has {strands} strands of {particles} "
            "particles; give the preset and the options that they were simulated with"
        )
    if dtype != np.dtype(np.float32):
        raise UsageError(f"{path}: positions are {dtype}, not float32; {AGAIN}")


def _words(error: Exception) -> str:
    """What an error says, of which names in a damaged archive may be many lines."""
    words = said(error)
    return words if len(words) < 200 else f"{words[:200]}…"


def _read_manifest(directory: Path) -> dict[str, Any]:
    path = directory / MANIFEST
    try:
        data = read_json(path)
    except UsageError as error:
        lacks = f"{directory}: has no {MANIFEST}; it is no folder of 'strandcli simulate'"
        raise UsageError(f"{error}; {AGAIN}" if path.exists() else lacks) from None
    entries = data.get("frames") if isinstance(data, dict) else None
    if not isinstance(entries, list) or not all(_is_entry(entry) for entry in entries):
        raise UsageError(
            f"{path}: 'frames' must list mappings of a frame number and the name of a file beside it; {AGAIN}"
        )
    return dict(data)


def _is_entry(entry: Any) -> bool:
    if not isinstance(entry, dict) or type(entry.get("frame")) is not int:
        return False
    name = entry.get("file")
    return isinstance(name, str) and bool(name) and name == Path(name).name
