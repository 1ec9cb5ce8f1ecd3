"""Presets that `strandcli new` writes: commented, and drawn as they are. Files are placed by their unit and up axis, as
they tell them or as these are guessed."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import UsageError

HEAD_SIZE = 0.28
"""Metres: longest side of a head without shoulders, for meshes of no known unit."""
GROOM_SIZE = 0.4
"""Likewise of strands that hang from one."""
DENSITIES = ("scalp", "density", "hair", "fur")
"""Attributes of vertices that tell where strands grow."""
UNKNOWN = "of the file; there is no evidence, so look at the picture"
COLUMN = 22
"""Width of a key with its value, before a comment."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A file, by the path that the preset names it by, with the lines of its placing, with comments; its longest side,
    metres; and the attribute by which strands grow on it."""

    file: str
    lines: tuple[str, ...]
    size: float
    up: str
    scale: float
    density: str | None = None


def named(path: Path, preset: Path) -> str:
    """A file's path as a preset names it: from the preset's folder where it lies there, below or beside it."""
    near = whole = path.resolve()
    with suppress(ValueError):  # on another drive
        near = Path(os.path.relpath(whole, preset.parent.resolve()))
    text = (near if near.parts.count("..") < 2 else whole).as_posix()
    if not text.isprintable():
        raise UsageError(f"{path}: its name has characters that a preset cannot have; rename it")
    return text


def mesh(path: Path, preset: Path) -> Placed:
    """A mesh placed by what its file tells, else by guesses. Raises `UsageError` where it cannot be read."""
    from ..meshes.facts import facts_of_file

    data, _ = facts_of_file(path)
    guess = data["guess"]
    names = {one["name"] for one in data["attributes"] if one["domain"] == "vertex"}
    density = next((name for name in DENSITIES if name in names), None)
    return _placed(
        named(path, preset), data, (guess["up"], "it stands on a flat side"), guess["unit"], HEAD_SIZE, density
    )


def strands(path: Path, preset: Path) -> Placed:
    """Strands placed by what their file tells, else by guesses."""
    from ..exchange.facts import facts_of_file
    from ..exchange.files import ReadOptions

    data = facts_of_file(path, ReadOptions())
    if data["box"] is None:
        raise UsageError(f"{path}: has no strand that could be drawn; 'strandcli info {path}' describes it")
    up = data["guess"]["up"]
    return _placed(named(path, preset), data, (up and up["axis"], "hair hangs from above"), None, GROOM_SIZE)


def _placed(
    file: str, data: Mapping[str, Any], up: tuple[str | None, str], unit: Mapping[str, Any] | None, usual: float,
    density: str | None = None,
) -> Placed:  # fmt: skip
    """A file placed by its facts; ``up``: the guess, and why; ``usual``: its size where nothing tells the unit."""
    axes: tuple[tuple[Any, str], ...] = ((data["up"], "as the file says"), (up[0], f"a guess: {up[1]}"), ("y", UNKNOWN))
    axis, why_up = next(pair for pair in axes if pair[0])
    longest, scale = max(data["box"]["size"]), data["unit"] or (unit and unit["scale"])
    guess = "as the file says" if data["unit"] or not unit else f"a guess: it is in {unit['unit']}"
    found = float(scale) if scale else usual / longest
    second = _line("scale", f"{found:.6g}", f"metres a unit, {guess}")
    if not scale:
        second = _line("size", f"{usual:g}", "metres, its longest side; the unit is not known")
    return Placed(file, (_line("up", axis, why_up), second), found * longest, axis, found, density)


def strands_on(path: Path, head: Placed, head_file: Path, preset: Path) -> tuple[Placed, str | None]:
    """Strands placed by how their roots lie on a placed mesh, and what to do where they lie on it in no way."""
    from ..exchange.files import ReadOptions
    from ..groom_file import fits  # Numba comes with it
    from ..solid_shapes.mesh import Settings

    solid = Settings(file=str(head_file), up=head.up, scale=head.scale)
    fit = fits.facts_on(path, ReadOptions(lenient=True), solid)
    found, warning = fit["mend"] or fit, None
    why = f"measured: roots lie {found['median']:.2g} m off the head in the median"
    if not fit["fits"] and fit["mend"] is None:
        why, warning = "not sure: roots lie off the head", f"{path}: {fits.said(fit)}"
    lines = _line("up", found["up"], why), _line("scale", f"{found['scale']:.6g}", why)
    return Placed(named(path, preset), lines, 0.0, found["up"], found["scale"]), warning


def _line(key: str, value: str, comment: str) -> str:
    return f"{f'{key}: {value}':<{COLUMN}} # {comment}"


HEAD = """\
# {title}
#   strandcli render {file} -f 1                      # one frame, in out/{name}
#   strandcli render {file} -f 1 --quality draft      # quickly
#   strandcli render {file} --watch                   # small, and anew whenever this file is saved
#   strandcli render {file} --animate gif             # all frames, and an animation
#   strandcli plan {file}                             # what would run, and the memory it takes
# Every key, with its unit and its default: 'strandcli schema --markdown'. `--set KEY=VALUE` tries one out.
# Units: metres, seconds, degrees. Axes: x right, y up, z to the viewer.
title: {quoted}

quality: default           # draft is quick, best is fine
seed: 1                    # of everything random
"""

MOVING = """
solver: rod                # elastic rods with mass; `thesis` is the simpler one, with rules of its own
rod: {rest: shape, drag: 8}   # rest shape: as grown; 1/s, rate at which the air moves them

time:
  fps: 24
  frames: 48
  preroll: 2               # seconds of falling into place before frame 1
"""

STILL = "\ntime: {frames: 1}          # strands stand as they are in the file; more once rules move them, see below\n"

EMITTER = """
emitter:                   # where strands grow
SHAPE
  strands: STRANDS             # that are simulated; children.count as many are drawn
  particles: 16            # of each of them
  length: LENGTH
  comb: COMB   # direction along the surface
  lift: LIFT                 # degrees off the surface
  jitter: 10               # degrees of disorder
"""
ON_BALL = "  shape: {kind: sphere, radius: 0.1, cap: 115}   # degrees from the top down"
TURNED = """\
  keys:                    # the motion of the ball
    - {time: 0, rotation: [0, 0, 0]}
    - {time: 1, rotation: [0, 50, 0]}
    - {time: 2, rotation: [0, 0, 0]}
"""
ON_MESH = """\
  shape:                   # the triangles that are drawn under `solids`; set file and placing alike there
    kind: mesh
    file: FILE
UP_AND_SCALE
    place: origin          # the middle of its box
ROOTS"""

OF_FILE = """
emitter:
  groom:                   # strands of a file; 'strandcli info' describes it
    file: FILE
UP_AND_SCALE
    fix: true              # what cannot be drawn is left out and reported
    cover: 5               # without widths: so wide that strands cover what is behind
ON
#    guides: 1000          # of strands that rules move: so many are simulated, and all follow
#  particles: 20           # of each guide
# To have them move: more `time.frames`, the two lines above without #, and
# solver: rod
# rod: {rest: sag_free}
# rules: [emitter_motion: {}, gravity: {}, wind: {strength: 2, gust: 0.6}]
"""

CHILDREN = """
children:                  # strands drawn about the simulated ones
  count: 24
  cut: 0.3                 # lengths are between 0.7 and 1 of a guide's
  clumps:                  # locks, and smaller ones in them
    - {size: LARGE, strength: 0.5}
    - {size: SMALL, strength: 0.7}
  waves:
    - {radius: WAVE, length: LONG, disorder: 0.4}
"""

RULES = """
rules:                     # in this order; a rule that is not listed costs nothing
  - emitter_motion
  - gravity                # acceleration: [0, -9.81, 0] m/s²
  - wind: {strength: 0.8, gust: 0.8, period: 1, wavelength: 0.4}   # m/s
  - collision              # with all solids below
"""

BALL = """
solids:                    # what strands collide with, and what hides those behind
  - {kind: sphere, radius: 0.099, follow: emitter, colour: [0.09, 0.05, 0.03]}
"""

MESH = """
solids:                    # what strands lie on, and what hides those behind
  - kind: mesh
    name: head
    file: FILE
UP_AND_SCALE
    place: PLACE
    follow: emitter
"""

CAMERA = """
camera:
  position: [{position}]
  target: [{target}]
  fov: 30                  # degrees, vertical{fit}

image:
  size: 800x600
  resolver: sorted         # strands as thin as they are, in the order of depth
  tone: filmic             # bright light rolls off
  background: [0.1, 0.11, 0.13]
  horizon: [0.3, 0.3, 0.31]   # colour at the bottom of the backdrop
"""

LIGHT = """
ambient: [0.3, 0.31, 0.34]
lights:
  - kind: directional      # key light, from the left
    direction: [0.55, -0.45, -0.85]
    intensity: 4
    size: 10               # degrees: a soft box
    colour: [1, 0.94, 0.86]
    shadow: {model: opacity}   # counts the strands between light and strand
  - kind: directional      # rim light, from behind
    direction: [-0.6, -0.3, 0.8]
    intensity: 1.6
    size: 10
    colour: [0.86, 0.93, 1]
    shadow: {model: opacity}

material:
  model: chiang            # light through and round each strand
  pigment: auburn          # black, dark_brown, brown, light_brown, red, dark_blond, blond, platinum, white
  colour_variation: 0.25   # from strand to strand
  scatter: dual            # light that goes from strand to strand
  diffuse: 0               # in place of the diffuse term
"""

FIT = "\n  fit: 0.86                # share of the picture that strands fill; moves the camera"
HAIR_WIDTH = "  width: 0.00035           # metres: each strand stands for a few\n  taper: 0.5\n"
IN_BOX = "    place: origin          # the middle of their box"
ON_HEAD = "    on: head               # the solid that roots are put on; strands inside are moved out"


def text(title: str, file: str, name: str, groom: Placed | None, head: Placed | None) -> str:
    """The text of a preset of this title in ``file``, whose frames go to out/``name``."""
    words = " ".join(title.split())
    parts = [HEAD.format(title=words, quoted=json.dumps(words, ensure_ascii=False), file=file, name=name)]
    if groom is not None:
        parts += [STILL, _filled(OF_FILE, groom, ON=IN_BOX if head is None else ON_HEAD)]
    elif head is not None:
        parts += [MOVING, _on_mesh(head), _children(head.size), RULES]
    else:
        ball = _filled(EMITTER, SHAPE=ON_BALL, STRANDS="600", LENGTH="0.18", COMB="[0.8, -0.3, 0.5]", LIFT="25")
        parts += [MOVING, ball, TURNED, _children(0.25), RULES, BALL]
    if head is not None:
        parts.append(_filled(MESH, head, PLACE="origin" if groom is None else "file"))
    size = 0.25 if head is None else head.size
    eye, fit = ((-0.5, 0.3, 1), FIT) if groom is not None else ((-1.1 * size, 0.35 * size, 2.7 * size), "")
    target = "0" if groom is not None else f"{-0.12 * size:.3g}"
    parts.append(CAMERA.format(position=", ".join(f"{one:.3g}" for one in eye), target=f"0, {target}, 0", fit=fit))
    parts.append(LIGHT + ("" if groom is not None else HAIR_WIDTH))
    return "".join(parts)


def _filled(section: str, placed: Placed | None = None, /, **words: str) -> str:
    """A section with its words in capitals filled in, and the lines of a file's placing."""
    if placed is not None:
        lines = "\n".join(f"    {line}" for line in placed.lines)
        words |= {"UP_AND_SCALE": lines, "FILE": json.dumps(placed.file, ensure_ascii=False)}
    for key, value in words.items():
        section = section.replace(key, value)
    return section


def _on_mesh(head: Placed) -> str:
    roots = f"    above: {0.12 * head.size:.3g}           # metres: strands grow above this height"
    if head.density is not None:
        roots = f"    density: {json.dumps(head.density)}   # an attribute of its vertices; nothing grows where it is 0"
    shape, length = _filled(ON_MESH, head, ROOTS=roots), f"{0.8 * head.size:.2g}"
    return _filled(EMITTER, SHAPE=shape, STRANDS="800", LENGTH=length, COMB="[0.5, -0.6, -0.6]", LIFT="15")


def _children(size: float) -> str:
    """Locks and waves for what is so large, metres."""
    shares = {"LARGE": 0.07, "SMALL": 0.02, "WAVE": 0.01, "LONG": 0.4}
    return _filled(CHILDREN, None, **{key: f"{share * size:.2g}" for key, share in shares.items()})
