"""Hypothesis strategies for valid scenes, built from the same specs that the validator reads."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hypothesis import strategies as st

from scene_kit import RULES
from strandcli.scene import RuleUse, Scene
from strandcli.scene.checks import findings
from strandcli.scene.fields import settings_of
from strandcli.scene.model import Emitter
from strandcli.scene.quality import settle
from strandcli.scene.specs import (
    LARGEST,
    NO_COLOUR,
    SMALLEST,
    BooleanSpec,
    ChoiceSpec,
    ColourSpec,
    FileSpec,
    IntegerSpec,
    ItemsSpec,
    MapSpec,
    ModelSpec,
    NamesSpec,
    NumberSpec,
    ParametersSpec,
    Range,
    SizeSpec,
    Spec,
    TextSpec,
    UnionSpec,
    VectorSpec,
    WindowSpec,
)

CONTROLS = [chr(code) for code in (*range(32), 127)]
texts = st.text(st.characters(exclude_categories=["Cs"], exclude_characters=CONTROLS), max_size=12)


def floats(limits: Range) -> st.SearchStrategy[float]:
    low = limits.low if limits.low is not None else limits.above if limits.above is not None else -LARGEST
    high = limits.high if limits.high is not None else limits.below if limits.below is not None else LARGEST
    if limits.above == 0:
        return st.floats(SMALLEST, float(high), exclude_max=limits.below is not None)
    return st.floats(
        float(low), float(high), exclude_min=limits.above is not None, exclude_max=limits.below is not None
    )


def values(spec: Spec) -> st.SearchStrategy[Any]:
    """Values that a setting may have."""
    match spec:
        case NumberSpec():
            found: st.SearchStrategy[Any] = floats(spec.limits)
        case IntegerSpec():
            found = st.integers(int(spec.limits.low or 0), int(spec.limits.high or LARGEST))
        case VectorSpec():
            found = st.tuples(*[floats(spec.limits)] * 3)
            if spec.nonzero:
                found = found.filter(lambda v: sum(abs(x) for x in v) > 1e-6)
        case ColourSpec():
            found = st.tuples(*[floats(Range(low=0))] * 3)
            found = st.just(NO_COLOUR) | found if spec.or_none else found
        case WindowSpec():
            found = st.tuples(*[st.integers(0, 9)] * 2, *[st.integers(1, 9)] * 2)
        case SizeSpec():
            found = st.tuples(*[st.integers(1, int(spec.limits.high or 1))] * 2)
        case ChoiceSpec():
            found = st.sampled_from(spec.options)
        case BooleanSpec():
            found = st.booleans()
        case MapSpec():
            found = st.sampled_from(["", "scalp", __file__])
        case FileSpec():
            found = st.just(__file__)
        case TextSpec():
            found = texts
        case ParametersSpec():
            return st.none()  # shipped drivers have none of their own
        case NamesSpec():
            found = st.just(())
        case ModelSpec():
            found = instances(spec.model)
        case UnionSpec():
            found = st.one_of([instances(cls) for cls in spec.kinds.values()])
        case ItemsSpec():
            found = st.lists(st.one_of([instances(cls) for cls in spec.kinds.values()]), max_size=2).map(tuple)
        case _:
            raise TypeError(type(spec))
    return found | st.none() if spec.default is None else found


def instances(cls: type) -> st.SearchStrategy[Any]:
    """Instances of a class made of settings, in which a few of them differ from their defaults."""
    settings = {s.attribute: values(s.spec) for s in settings_of(cls).values() if s.key not in ("rules", "panels")}
    return st.fixed_dictionaries({}, optional=settings).map(lambda chosen: cls(**chosen))


def rule_uses() -> st.SearchStrategy[tuple[RuleUse, ...]]:
    """Lists of rules, with the paths that a preset would give them."""
    one = st.one_of([st.tuples(st.just(name), instances(rule.Parameters)) for name, rule in RULES.items()])

    def with_paths(pairs: list[tuple[str, Any]]) -> tuple[RuleUse, ...]:
        counts = dict.fromkeys(RULES, 0)
        uses = []
        for name, parameters in pairs:
            counts[name] += 1
            path = name if counts[name] == 1 else f"{name}[{counts[name]}]"
            uses.append(RuleUse(name, parameters, path))
        return tuple(uses)

    return st.lists(one, max_size=4).map(with_paths)


def with_file_alone(scene: Scene) -> Scene:
    """The scene without what does not go with strands from a file, where it has such, and without what needs one."""
    emitter, given, camera = scene.emitter, scene.emitter.groom, scene.camera
    if given is None or camera.keys:
        camera = replace(camera, fit=None)
    if camera.keys:
        camera = replace(camera, file=None)
    if given is None:
        return replace(scene, camera=camera)
    given = replace(given, file=__file__, scale=given.scale if given.size is None else None)
    emitter = Emitter(groom=given, position=emitter.position, rotation=emitter.rotation, keys=emitter.keys)
    rules = tuple(use for use in scene.rules if use.name == "emitter_motion")
    return replace(scene, emitter=emitter, camera=camera, rules=rules, children=None)


def single_scenes() -> st.SearchStrategy[Scene]:
    """Valid scenes without panels."""
    settings = {
        setting.attribute: rule_uses() if setting.key == "rules" else values(setting.spec)
        for setting in settings_of(Scene).values()
        if setting.key != "panels"
    }
    scenes = st.fixed_dictionaries({}, optional=settings).map(
        lambda chosen: settle(with_file_alone(Scene(**chosen)), ())[0]
    )
    return scenes.filter(lambda scene: not list(findings(scene)))
