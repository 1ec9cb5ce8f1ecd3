"""What a person wrote: presets, typed and validated, with units and source lines. Imports no numpy and no numba."""

from .dump import dump, to_dict
from .faults import Fault, SceneError
from .library import describe as describe_preset
from .library import find, list_presets
from .loading import load, loads
from .model import RuleUse, Scene
from .rule_type import RuleType
from .schema import json_schema
