"""The text of a new preset: sections with comments, filled in with what was measured of files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from . import Placed

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

STILL = """
time: {frames: 1}          # strands stand as they are in the file; more frames once rules move them, see below
"""

ON_BALL = """
emitter:                   # where strands grow
  shape: {kind: sphere, radius: 0.1, cap: 115}   # degrees from the top down
  strands: 600             # that are simulated; children.count as many are drawn
  particles: 16            # of each of them
  length: 0.18
  comb: [0.8, -0.3, 0.5]   # direction along the surface
  lift: 25                 # degrees off the surface
  jitter: 10               # degrees of disorder
  keys:                    # the motion of the ball
    - {time: 0, rotation: [0, 0, 0]}
    - {time: 1, rotation: [0, 50, 0]}
    - {time: 2, rotation: [0, 0, 0]}
"""

ON_MESH = """
emitter:                   # where strands grow
  shape:                   # the triangles that are drawn under `solids`; set file and placing alike there
    kind: mesh
    file: FILE
UP_AND_SCALE
    place: origin          # the middle of its box
ROOTS
  strands: 800             # that are simulated; children.count as many are drawn
  particles: 16            # of each of them
  length: LENGTH
  comb: [0.5, -0.6, -0.6]  # direction along the surface
  lift: 15                 # degrees off the surface
  jitter: 10               # degrees of disorder
"""

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


def text(title: str, file: str, name: str, groom: Placed | None, head: Placed | None) -> str:
    """The text of a preset of this title in ``file``, whose frames go to out/``name``."""
    words = " ".join(title.split())
    parts = [HEAD.format(title=words, quoted=json.dumps(words, ensure_ascii=False), file=file, name=name)]
    if groom is not None:
        parts += [STILL, _of_file(groom, head)]
    elif head is not None:
        parts += [MOVING, _on_mesh(head), _children(head.size), RULES]
    else:
        parts += [MOVING, ON_BALL, _children(0.25), RULES, BALL]
    if head is not None:
        parts.append(_filled(MESH, head, PLACE="origin" if groom is None else "file"))
    parts += [_camera(groom, head), LIGHT + ("" if groom is not None else HAIR_WIDTH)]
    return "".join(parts)


def _filled(section: str, placed: Placed, **words: str) -> str:
    """A section with the lines of a file's placing."""
    lines = "\n".join(f"    {line}" for line in placed.lines)
    found = section.replace("UP_AND_SCALE", lines)
    for key, value in {"FILE": json.dumps(placed.file, ensure_ascii=False), **words}.items():
        found = found.replace(key, value)
    return found


def _of_file(groom: Placed, head: Placed | None) -> str:
    if head is None:
        return _filled(OF_FILE, groom, ON="    place: origin          # the middle of their box")
    return _filled(
        OF_FILE, groom, ON="    on: head               # the solid that roots are put on; strands inside are moved out"
    )


def _on_mesh(head: Placed) -> str:
    if head.density is not None:
        roots = f"    density: {json.dumps(head.density)}   # an attribute of its vertices; nothing grows where it is 0"
    else:
        roots = f"    above: {0.12 * head.size:.3g}           # metres: strands grow above this height"
    return _filled(ON_MESH, head, ROOTS=roots, LENGTH=f"{0.8 * head.size:.2g}")


def _children(size: float) -> str:
    """Locks and waves for what is so large, metres."""
    numbers: Mapping[str, Any] = {"LARGE": 0.07 * size, "SMALL": 0.02 * size, "WAVE": 0.01 * size, "LONG": 0.4 * size}
    found = CHILDREN
    for key, value in numbers.items():
        found = found.replace(key, f"{value:.2g}")
    return found


def _camera(groom: Placed | None, head: Placed | None) -> str:
    """A camera that sees all of it: of strands of a file `fit` sees to that."""
    if groom is not None:
        return CAMERA.format(position="-0.5, 0.3, 1", target="0, 0, 0", fit=FIT)
    size = 0.25 if head is None else head.size
    numbers = ", ".join(f"{one * size:.3g}" for one in (-1.1, 0.35, 2.7))
    return CAMERA.format(position=numbers, target=f"0, {-0.12 * size:.3g}, 0", fit="")
