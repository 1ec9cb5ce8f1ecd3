"""The kinds of setting that a preset has. One class a kind says all of it: what it takes, within which limits, how
it is read of a preset, and its part of the JSON Schema."""

from .base import LARGEST, SMALLEST, Range, Refusal, Spec, as_number
from .mappings import MOST_ITEMS, MOST_PANELS, ItemsSpec, ModelSpec, PanelsSpec, ParametersSpec, RulesSpec, UnionSpec
from .values import (
    NO_COLOUR,
    BooleanSpec,
    ChoiceSpec,
    ColourSpec,
    FileSpec,
    IntegerSpec,
    MapSpec,
    NamesSpec,
    NumberSpec,
    SizeSpec,
    TextSpec,
    VectorSpec,
    WindowSpec,
)  # fmt: skip
