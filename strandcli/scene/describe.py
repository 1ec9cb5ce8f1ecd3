"""What a setting takes, in the words that follow "must be" in messages."""

from __future__ import annotations

from .specs import (
    NO_COLOUR,
    BooleanSpec,
    ChoiceSpec,
    ColourSpec,
    FileSpec,
    IntegerSpec,
    ItemsSpec,
    MapSpec,
    NamesSpec,
    NumberSpec,
    PanelsSpec,
    Range,
    RulesSpec,
    SizeSpec,
    Spec,
    TextSpec,
    VectorSpec,
    WindowSpec,
)


def wanted(spec: Spec) -> str:
    """What ``spec`` takes, as in "a number above 0 (m)"."""
    match spec:
        case NumberSpec():
            return _joined("a number", spec.limits, spec.unit)
        case IntegerSpec():
            return _joined("a whole number", spec.limits, spec.unit)
        case VectorSpec():
            each = f" each {spec.limits}" if str(spec.limits) else ""
            return f"three numbers [x, y, z]{each}{_unit(spec.unit)}"
        case ColourSpec():
            none = f", or {NO_COLOUR}" if spec.or_none else ""
            return f'three linear numbers [r, g, b] or "#rrggbb" in quotes{none}'
        case SizeSpec():
            return f'a size [w, h] or "800x600" of at least 1 and at most {spec.limits.high}{_unit(spec.unit)}'
        case WindowSpec():
            return f'a part of the picture [x, y, width, height] or "400x300+100+50"{_unit(spec.unit)}'
        case ChoiceSpec():
            return spec.options[0] if len(spec.options) == 1 else f"one of {', '.join(spec.options)}"
        case BooleanSpec():
            return "true or false"
        case FileSpec():
            return "the path of a file"
        case MapSpec():
            return "the name of an attribute, or the path of a picture"
        case TextSpec():
            return "text"
        case NamesSpec():
            return "a name or a list of names"
        case ItemsSpec() | PanelsSpec():
            return "a list, each entry beginning with `- `"
        case RulesSpec():
            return "a list or a mapping of rules"
    return "a mapping of settings"


def _joined(what: str, limits: Range, unit: str) -> str:
    words = str(limits)
    return f"{what} {words}{_unit(unit)}" if words else f"{what}{_unit(unit)}"


def _unit(unit: str) -> str:
    return f" ({unit})" if unit and unit != "1" else ""
