"""Pictures in a terminal: by the protocols of kitty and iTerm2, and elsewhere as half-blocks in colour.

Sources: kitty's "Terminal graphics protocol"; iTerm2's "Images" (OSC 1337).
"""

from __future__ import annotations

import base64
import os
import shutil
import sys
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Pixels = npt.NDArray[np.uint8]

CHUNK = 4096
"""Characters of a piece of kitty's protocol at most."""
CELL = 10
"""Pixels that a column of a terminal is taken for: pictures are sent no wider than they are seen."""
UPPER_HALF = "\u2580"
ITERM2 = ("iTerm.app", "WezTerm", "vscode", "mintty", "WarpTerminal")
KITTY = ("ghostty", "kitty")
PAUSE = 1.0
"""Seconds between two pictures of a film at least."""


def detected(environment: Mapping[str, str]) -> str:
    """The kind of pictures that a terminal shows, by the variables that it sets; ``blocks`` where none tells, and
    within tmux and screen, which hand no pictures on."""
    term, program = environment.get("TERM", ""), environment.get("TERM_PROGRAM", "")
    if environment.get("TMUX") or term.startswith(("screen", "tmux")):
        return "blocks"
    if environment.get("KITTY_WINDOW_ID") or "kitty" in term or program in KITTY:
        return "kitty"
    if program in ITERM2 or environment.get("LC_TERMINAL") == "iTerm2":
        return "iterm2"
    return "blocks"


def kitty(image: Pixels) -> str:
    """A picture in kitty's protocol: PNG in pieces of base64."""
    from ..output.png import encode

    data = base64.b64encode(b"".join(encode(image))).decode("ascii")
    pieces = [data[i : i + CHUNK] for i in range(0, len(data), CHUNK)]
    found = []
    for place, piece in enumerate(pieces):
        more = int(place < len(pieces) - 1)
        keys = f"a=T,f=100,q=2,m={more}" if place == 0 else f"m={more}"
        found.append(f"\x1b_G{keys};{piece}\x1b\\")
    return "".join(found) + "\n"


def iterm2(image: Pixels) -> str:
    """A picture in iTerm2's protocol."""
    from ..output.png import encode

    data = b"".join(encode(image))
    text = base64.b64encode(data).decode("ascii")
    return f"\x1b]1337;File=inline=1;size={len(data)};preserveAspectRatio=1:{text}\x07\n"


def blocks(image: Pixels) -> str:
    """A picture as half-blocks: a character for two pixels, the upper one in its colour before that of the lower."""
    lines = []
    for y in range(0, image.shape[0] - 1, 2):
        last, line = "", []
        for (r, g, b), (r2, g2, b2) in zip(image[y].tolist(), image[y + 1].tolist(), strict=True):
            colours = f"\x1b[38;2;{r};{g};{b};48;2;{r2};{g2};{b2}m"
            line.append((colours if colours != last else "") + UPPER_HALF)
            last = colours
        lines.append("".join(line) + "\x1b[0m\n")
    return "".join(lines)


KINDS: Mapping[str, Callable[[Any], str]] = {"kitty": kitty, "iterm2": iterm2, "blocks": blocks}


def drawn(image: Pixels, kind: str, columns: int, rows: int) -> str:
    """What a terminal of so many columns and rows is sent to show a picture (H, W, 3), with a few rows left free."""
    limit = (columns, 2 * max(1, rows - 4)) if kind == "blocks" else (columns * CELL, 2 * CELL * max(1, rows - 4))
    return KINDS[kind](_fitted(image, limit))


def _fitted(image: Pixels, limit: tuple[int, int]) -> Pixels:
    """A picture within (width, height), smaller in proportion; never larger than it is."""
    import numpy as np
    from PIL import Image

    height, width = image.shape[:2]
    share = min(1.0, limit[0] / width, limit[1] / height)
    size = (max(1, int(width * share)), max(2, int(height * share)))
    if size == (width, height):
        return image
    return np.asarray(Image.fromarray(image).resize(size, Image.Resampling.LANCZOS))


class Preview:
    """Shows pictures on standard output, where that is a terminal or a kind was named."""

    def __init__(self, kind: str | None) -> None:
        """``kind``: one of `KINDS`, ``auto``, or None for none."""
        shown = kind is not None and (kind != "auto" or sys.stdout.isatty())
        self.kind = (detected(os.environ) if kind == "auto" else kind) if shown else None
        self._last = -PAUSE

    def next(self, image: Pixels) -> None:
        """Show a picture of a film, unless the last one was shown just before."""
        now = time.monotonic()
        if now - self._last >= PAUSE:
            self._last = now
            self.show(image)

    def show(self, image: Pixels, *, alone: bool = False) -> None:
        """Show a picture (H, W, 3), or one with alpha over grey; ``alone``: on an empty screen."""
        if self.kind is None:
            return
        from ..output.png import over

        size = shutil.get_terminal_size()
        text = ("\x1b[H\x1b[2J" if alone else "") + drawn(over(image), self.kind, size.columns, size.lines)
        sys.stdout.write(text)
        sys.stdout.flush()


preview_option = click.option(
    "--preview", type=click.Choice(("auto", *KINDS)), is_flag=False, flag_value="auto", metavar="[KIND]",
    help="Show frames in the terminal: kitty, iterm2 or blocks.  [default KIND: what the terminal can]",
)  # fmt: skip
