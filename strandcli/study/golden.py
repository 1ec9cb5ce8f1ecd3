"""Golden images: small pictures that were once looked at and found good, and that every later version must draw again.

A folder holds ``golden.yaml``, the list of them (docs/golden-images.md), and, made by `update`, a ``NAME.png`` for each
and ``hashes.json`` with the hashes of decoded pixels.

Two machines of one class (`machine_class`) must agree in every bit. On a machine of a class that no hash was recorded
for, sines and rounding may differ by an ulp, which moves a strand across the edge of a pixel here and there; there a
picture may differ in at most ``most_over`` of its pixels by more than `THRESHOLD`, and by ``most_rmse`` over all.
Nothing else in strandcli has a tolerance for images.
"""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SimulationError, UsageError
from ..files.inputs import content
from ..output import png
from ..output.compare import Comparison, compare, side_by_side, size_of, write_image
from ..output.files import prepare_folder, read_json, write_json

LIST = "golden.yaml"
_LARGEST = 1 << 20
"""Bytes of a list."""
MOST_OVER, MOST_RMSE = 0.001, 1.0
"""The tolerance of an image that states none: a share of all pixels, and of 255."""
NAME, SIZE = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*"), re.compile(r"([1-9][0-9]{0,4})x([1-9][0-9]{0,4})")
KEYS: Mapping[str, tuple[Callable[[Any], Any], str]] = {
    "preset": (lambda one: isinstance(one, str) and one, "a shipped name or a file"),
    "name": (lambda one: isinstance(one, str) and NAME.fullmatch(one), "letters, digits, '.', '_' or '-'"),
    "frame": (lambda one: type(one) is int and one >= 1, "a whole number from 1"),
    "size": (lambda one: isinstance(one, str) and SIZE.fullmatch(one), "a width and a height such as 160x120"),
    "set": (
        lambda one: isinstance(one, list) and all(isinstance(text, str) and "=" in text for text in one),
        "a list of texts such as 'wind.strength=3'",
    ),
    "allow": (lambda one: type(one) in (int, float) and 0 <= one <= 100, "a number from 0 to 100"),
    "rmse": (lambda one: type(one) in (int, float) and 0 <= one <= 255, "a number from 0 to 255"),
}
"""By key: whether a value is one, and what it must be."""
THRESHOLD = 8  # of 255
HASHES = "hashes.json"
SCHEMA_VERSION = 1


@dataclass(frozen=True, slots=True)
class Entry:
    """One golden image: what to draw, and the name of its file without .png."""

    name: str
    preset: str
    overrides: tuple[str, ...] = ()
    frame: int = 1
    size: tuple[int, int] | None = None
    most_over: float = MOST_OVER
    most_rmse: float = MOST_RMSE


Notify = Callable[[str], None]
Draw = Callable[[Entry, Path], png.Pixels]


@dataclass(frozen=True, slots=True)
class Result:
    """What became of one entry. ``difference`` is the picture that shows a mismatch, where there is one."""

    entry: Entry
    matches: bool
    words: str
    comparison: Comparison | None = None
    difference: Path | None = None

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        entry, comparison, difference = self.entry, self.comparison, self.difference
        return {
            "name": entry.name, "preset": entry.preset, "frame": entry.frame, "matches": self.matches,
            "why": self.words, "comparison": comparison and comparison.as_dict(),
            "difference": difference and str(difference),
        }  # fmt: skip


def machine_class() -> str:
    """The name of all machines whose pictures agree in every bit: same instruction set, and the same makers of code and
    of elementary functions. Numba's kernels use arithmetic and square roots alone, but roots are placed with NumPy's
    sines, which depend on its version and on the widest SIMD it finds, keys are turned with those of the C library, and
    Pillow writes the labels of panels.
    """
    import llvmlite.binding as llvm
    import numba
    import PIL

    shown: Any = np.show_config(mode="dicts")
    simd = shown.get("SIMD Extensions", {})
    widest = (simd.get("found") or simd.get("baseline") or ["plain"])[-1]
    versions = {name: ".".join(module.__version__.split(".")[:2])
                for name, module in (("numba", numba), ("numpy", np), ("pillow", PIL))}  # fmt: skip
    libc, version = platform.libc_ver()
    return (
        f"{platform.machine()} {widest} numba-{versions['numba']} llvm-{llvm.llvm_version_info[0]} "
        f"numpy-{versions['numpy']} {libc or 'libc'}-{version or 'unknown'} pillow-{versions['pillow']}"
    )


def tolerable(comparison: Comparison, entry: Entry) -> bool:
    """Whether a difference may come from another class of machine; ``comparison`` must be made with ``THRESHOLD``."""
    return comparison.over_fraction <= entry.most_over and comparison.rmse <= entry.most_rmse


def draw(entry: Entry, directory: Path, notify: Notify | None = None, threads: int | None = None) -> png.Pixels:
    """The picture of an entry, drawn now: uint8, (height, width, 3), or 4 with alpha."""
    import strandcli

    from ..run import pipeline

    preset = entry.preset
    if preset.endswith((".yaml", ".yml")):
        preset = str(directory / preset)
    size = {"image.size": entry.size} if entry.size else None
    scene = strandcli.load(preset, entry.overrides, size, option="set")
    if entry.frame > scene.time.frames:
        raise UsageError(
            f"{directory / LIST}: {entry.name}: frame {entry.frame} is beyond the last, {scene.time.frames}"
        )
    (frame,) = pipeline.render(scene, [entry.frame], threads=threads, notify=notify)
    image: png.Pixels = np.array(frame.image)
    return image


def check(directory: Path, entry: Entry, output: Path, drawer: Draw) -> Result:
    """Draw an entry and hold it against its golden image; a mismatch leaves ``output``/NAME.diff.png with expected,
    found and difference side by side."""
    picture = directory / f"{entry.name}.png"
    record = read_hashes(directory).get(entry.name)
    if not picture.exists() or record is None:
        lost = picture.name if not picture.exists() else f"its hash in {HASHES}"
        return Result(entry, False, f"{lost} is missing; look at the picture and run 'strandcli golden update'")
    expected = png.read(picture)
    try:
        found = drawer(entry, directory)
    except SimulationError as error:
        return Result(entry, False, f"could not be drawn: {error}")
    exact = record["classes"].get(machine_class())
    if png.pixels_sha256(expected) != record["picture"]:
        words = f"{picture.name} is not the image that {HASHES} was written for"
    elif expected.shape != found.shape:
        words = f"sizes differ: {size_of(expected)} against {size_of(found)}"
    elif exact is not None and png.pixels_sha256(found) != exact:
        words = "not the pixels recorded for machines of this class"
    elif exact is None and not tolerable(compare(expected, found, THRESHOLD), entry):
        words = "beyond the tolerance for machines of another class"
    else:
        return Result(entry, True, "exact" if exact is not None else "within the tolerance for another machine class")
    if expected.shape != found.shape:
        path = _keep(output, f"{entry.name}.found.png", found)
        return Result(entry, False, words, None, path)
    comparison = compare(expected, found, 0 if exact is not None else THRESHOLD)
    path = _keep(output, f"{entry.name}.diff.png", side_by_side(expected, found))
    return Result(entry, False, f"{words}: {comparison}", comparison, path)


def _keep(output: Path, name: str, image: png.Pixels) -> Path:
    prepare_folder(output, image.nbytes)
    write_image(output / name, image)
    return output / name


def update(directory: Path, entry: Entry, drawer: Draw) -> str | None:
    """Draw an entry and make it the golden image; returns what changed, or None if nothing did.

    On a machine of a new class, a picture within the tolerance stays and only its hash is added; otherwise the picture
    is replaced, and with it go the hashes of other classes, which were of another picture.
    """
    picture = directory / f"{entry.name}.png"
    hashes = read_hashes(directory)
    record = hashes.get(entry.name)
    here = machine_class()
    found = drawer(entry, directory)
    digest = png.pixels_sha256(found)
    old = None
    with suppress(UsageError):
        old = png.read(picture)
    if old is not None and record is not None and png.pixels_sha256(old) == record["picture"]:
        if record["classes"].get(here) == digest:
            return None
        same = old.shape == found.shape and tolerable(compare(old, found, THRESHOLD), entry)
        if here not in record["classes"] and same:
            record["classes"][here] = digest
            write_hashes(directory, hashes)
            return "hash added for this class of machine"
    write_image(picture, found)
    hashes[entry.name] = {"picture": digest, "classes": {here: digest}}
    write_hashes(directory, hashes)
    if old is None:
        return "new"
    if old.shape != found.shape:
        return f"now {size_of(found)}, was {size_of(old)}"
    return f"changed: {compare(old, found)}"


def prune(directory: Path, entries: Sequence[Entry]) -> list[str]:
    """Forget the hashes and pictures of entries that are no longer listed; returns their names."""
    hashes = read_hashes(directory)
    names = {entry.name for entry in entries}
    gone = [name for name in hashes if name not in names]
    for name in gone:
        (directory / f"{name}.png").unlink(missing_ok=True)
        del hashes[name]
    if gone:
        write_hashes(directory, hashes)
    return gone


def read_hashes(directory: Path) -> dict[str, Any]:
    """The records of hashes.json: name to ``{"picture": hash of the .png, "classes": {machine class: hash}}``."""
    path = directory / HASHES
    if directory.is_dir() and not os.path.lexists(path):
        return {}
    data = read_json(path)
    images = data.get("images") if isinstance(data, dict) else None
    kinds = {"picture": str, "classes": dict}
    if not isinstance(images, dict) or not all(
        isinstance(one, dict) and all(isinstance(one.get(key), kind) for key, kind in kinds.items())
        for one in images.values()
    ):
        raise UsageError(f"{path}: is damaged; remove it and run 'strandcli golden update'")
    return images


def write_hashes(directory: Path, images: dict[str, Any]) -> None:
    """Write hashes.json, whole or not at all."""
    data = {"schema_version": SCHEMA_VERSION, "images": {name: images[name] for name in sorted(images)}}
    write_json(directory / HASHES, data)


def read_entries(directory: Path) -> list[Entry]:
    """The list of a folder. Raises ``UsageError`` that names the entry at fault."""
    import yaml

    path = directory / LIST
    if directory.is_dir() and not os.path.lexists(path):
        raise UsageError(f"{path}: no such file; it lists the golden images, as in '- preset: hair'")
    data = content(path, _LARGEST)
    try:
        found = yaml.safe_load(data)
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise UsageError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(found, list) or not found:
        raise UsageError(f"{path}: must be a list of entries such as '- preset: hair'")
    entries = [_entry(one, f"{path}: entry {number}") for number, one in enumerate(found, 1)]
    names = [entry.name for entry in entries]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"{path}: two entries are named '{name}'; give one another 'name'")
    return entries


def _entry(data: Any, where: str) -> Entry:
    if not isinstance(data, dict):
        raise UsageError(f"{where}: must be a mapping such as 'preset: hair'")
    for key, value in {"preset": None, **data}.items():
        if key not in KEYS:
            raise UsageError(f"{where}: unknown key '{key}'; the keys are {', '.join(KEYS)}")
        is_sound, words = KEYS[key]
        if not is_sound(value):
            raise UsageError(f"{where}: '{key}' must be {words}, not {value!r}")
    preset = data["preset"]
    name = Path(preset).stem if preset.endswith((".yaml", ".yml")) else preset.replace("/", "-")
    wide, high = map(int, data["size"].split("x")) if "size" in data else (0, 0)
    return Entry(
        data.get("name", name), preset, tuple(data.get("set", ())), data.get("frame", 1),
        (wide, high) if wide else None, data.get("allow", 100 * MOST_OVER) / 100, float(data.get("rmse", MOST_RMSE)),
    )  # fmt: skip


def select(entries: Sequence[Entry], names: Sequence[str]) -> list[Entry]:
    """The entries of these names, or all if there are none. Raises ``UsageError`` for a name that is not there."""
    known = [entry.name for entry in entries]
    for name in names:
        if name not in known:
            raise UsageError(f"no golden image is named '{name}'; there are {', '.join(known)}")
    return [entry for entry in entries if not names or entry.name in names]
