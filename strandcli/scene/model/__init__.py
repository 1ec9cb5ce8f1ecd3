"""What a person writes in a preset, as typed and frozen data.

Every class here mirrors one mapping of the YAML file. A field's default, unit, range and meaning stand together, and
the validator (`validate.py`), the JSON Schema (`schema.py`) and the documentation all read them from here.

One file a topic; `Scene` is the whole.

Units: metres, seconds, degrees. Axes are right-handed with y up. A colour is three linear Rec. 709 numbers, or a
string "#rrggbb" which is read as sRGB.
"""

from __future__ import annotations

from .camera import (
    AOVS,
    LIGHTS,
    AmbientOcclusion,
    Camera,
    CameraKey,
    DirectionalLight,
    Environment,
    Image,
    Light,
    PointLight,
    Shadow,
)  # fmt: skip
from .emitter import DiscShape, Emitter, Extent, Followers, GroomFile, PlaneShape, SphereShape, Tie
from .placed import MeshKey, MeshShape, PoseKey
from .scene import RuleUse, Scene, Time
from .solids import SOLIDS, BoxSolid, CapsuleSolid, PlaneSolid, Solid, SolidSettings, SphereSolid
from .strands import PIGMENTS, Children, Clump, Curves, Detail, Material, Rod, Wave
