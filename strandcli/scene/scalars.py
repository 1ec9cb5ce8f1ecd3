"""The text of a single value to a number, a truth value, text or a colour: asked for by type, never guessed.

YAML 1.1 and 1.2 readers disagree on much (`010`, `1_000`, `12:30`, `no`). Whatever two readers would take for different
values is refused here with the reason.
"""

from __future__ import annotations

import math
import re

from .faults import shown
from .nodes import Scalar
from .specs import NO_COLOUR

_DECIMAL = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_OCTAL = re.compile(r"0o[0-7]+")
_LEADING_ZERO = re.compile(r"[-+]?0+[0-9]+")
_UNDERSCORES = re.compile(r"[-+]?[0-9][0-9_.]*_[0-9_.]*(?:[eE][-+]?[0-9]+)?|0[xo][0-9a-fA-F_]+")
_BASE_60 = re.compile(r"[-+]?[0-9]+(?::[0-9]+)+(?:\.[0-9]*)?")
_COMMA = re.compile(r"([-+]?[0-9]+),([0-9]+)")
_NOT_FINITE = re.compile(r"[-+]?\.?(?:inf|infinity|nan)", re.IGNORECASE)
_HEX_COLOUR = re.compile(r"#[0-9a-fA-F]{6}")
_TRUE = ("true", "True", "TRUE")
_FALSE = ("false", "False", "FALSE")
_YES = ("yes", "on", "y")
_NO = ("no", "off", "n")
_LONGEST_INTEGER = 40
_LONGEST_NUMBER = 400


class Refusal(ValueError):
    """A value that is not what was asked for; the message says why, as in "not '12:30'"."""


def as_number(scalar: Scalar) -> int | float:
    """A finite number. Raises Refusal."""
    text = scalar.text
    if not scalar.plain:
        if _FLOAT.fullmatch(text):
            raise Refusal(f"not the text {shown(text)}; take the quotes away")
        raise Refusal(f"not the text {shown(text)}")
    if len(text) > _LONGEST_NUMBER:
        raise Refusal(f"not {shown(text)}")
    if _LEADING_ZERO.fullmatch(text) and text.strip("+-0"):
        raise Refusal(f"not {shown(text)}: with a leading zero YAML readers disagree whether it is octal")
    if _DECIMAL.fullmatch(text) and len(text) <= _LONGEST_INTEGER:
        return int(text)
    if _HEX.fullmatch(text) or _OCTAL.fullmatch(text):
        if len(text) > _LONGEST_INTEGER:
            raise Refusal(f"not {shown(text)}, which is too large for a number")
        return int(text, 0)
    if _FLOAT.fullmatch(text):
        value = float(text)
        if math.isinf(value):
            raise Refusal(f"not {shown(text)}, which is too large for a number")
        return value
    raise Refusal(f"not {shown(text)}{_why_no_number(text)}")


def _why_no_number(text: str) -> str:
    """What is the matter with a text that looks like a number to some."""
    if _NOT_FINITE.fullmatch(text):
        return "; it must be finite"
    if _BASE_60.fullmatch(text):
        return ": some YAML readers take this for base 60; write one number"
    if _UNDERSCORES.fullmatch(text):
        return f"; write {text.replace('_', '')}"
    if comma := _COMMA.fullmatch(text):
        return f"; write {comma[1]}.{comma[2]} with a point"
    return ""


def as_boolean(scalar: Scalar) -> bool:
    """A truth value. Raises Refusal."""
    if scalar.plain and scalar.text in _TRUE:
        return True
    if scalar.plain and scalar.text in _FALSE:
        return False
    word = scalar.text.lower()
    if scalar.plain and (word in _YES or word in _NO):
        meant = "true" if word in _YES else "false"
        raise Refusal(f"not {shown(scalar.text)}, which YAML readers disagree about; write {meant}")
    raise Refusal(f"not {shown(scalar.text)}")


def as_colour(scalar: Scalar, or_none: bool = False) -> tuple[float, float, float] | str:
    """The linear colour of "#rrggbb" in sRGB (IEC 61966-2-1), or `NO_COLOUR` if that may be. Raises Refusal."""
    if or_none and scalar.text == NO_COLOUR:
        return NO_COLOUR
    if not _HEX_COLOUR.fullmatch(scalar.text):
        raise Refusal(f"not {shown(scalar.text)}")
    red, green, blue = (linear(int(scalar.text[i : i + 2], 16) / 255.0) for i in (1, 3, 5))
    return red, green, blue


def linear(encoded: float) -> float:
    """The linear value of an sRGB-encoded channel in 0 ... 1 (IEC 61966-2-1)."""
    if encoded <= 0.04045:
        return encoded / 12.92
    return math.pow((encoded + 0.055) / 1.055, 2.4)


def as_window(scalar: Scalar) -> tuple[int, int, int, int]:
    """x, y, width and height of "400x300+100+50", the size first. Raises Refusal."""
    parts = re.fullmatch(r"([0-9]{1,9})\s*[x×]\s*([0-9]{1,9})\s*\+\s*([0-9]{1,9})\s*\+\s*([0-9]{1,9})", scalar.text)
    if parts is None:
        raise Refusal(f"not {shown(scalar.text)}")
    width, height, x, y = (int(part) for part in parts.groups())
    return x, y, width, height


def as_size(scalar: Scalar) -> tuple[int, int]:
    """The two numbers of "800x600". Raises Refusal."""
    parts = re.fullmatch(r"([0-9]{1,9})\s*[x×]\s*([0-9]{1,9})", scalar.text)
    if parts is None:
        raise Refusal(f"not {shown(scalar.text)}")
    return int(parts[1]), int(parts[2])
