"""Golden images: small pictures that were once looked at and found good, and that every later version must draw again.

A folder holds ``golden.yaml``, the list of them (`strandcli.study.golden_list`), and,
made by `update`, a ``NAME.png`` for each and ``hashes.json`` with the hashes of decoded pixels.

Two machines of one class (`machine_class`) must agree in every bit. On a machine of a class that no hash was recorded
for, sines and rounding may differ by an ulp, which moves a strand across the edge of a pixel here and there; there a
picture may differ in at most ``most_over`` of its pixels by more than `THRESHOLD`, and by ``most_rmse`` over all.
Nothing else in strandcli has a tolerance for images. On a head of 3,000 strands an ulp in lengths or frame rate changed
no pixel by more than 4/255, ten ulps none by more than 6/255; strands .6 % longer changed 1.8 to 7.6 % of all pixels by
more than 8/255.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SimulationError, UsageError
from ..output import png
from ..output.compare import Comparison, compare, side_by_side, size_of, write_image
from ..output.files import prepare_folder, write_json
from .golden_list import LIST, Entry

THRESHOLD = 8  # of 255
HASHES = "hashes.json"
SCHEMA_VERSION = 1

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
        return {
            "name": self.entry.name,
            "preset": self.entry.preset,
            "frame": self.entry.frame,
            "matches": self.matches,
            "why": self.words,
            "comparison": self.comparison.as_dict() if self.comparison else None,
            "difference": str(self.difference) if self.difference else None,
        }


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
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"{path}: cannot be read: {error}") from None
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
