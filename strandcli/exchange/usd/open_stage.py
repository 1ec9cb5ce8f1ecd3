"""Stages of USD and the files that they are made of; runs in the worker."""

from __future__ import annotations

from pxr import Sdf, Usd

from .messages import RefusedFileError
from .text import layer_of_text


def opened(path: str) -> Usd.Stage:
    """The stage of a file. Raises `RefusedFileError` and Tf.ErrorException."""
    layer = layer_of_text(path)
    if layer is None:
        known = Sdf.Layer.Find(path)
        layer = known or Sdf.Layer.FindOrOpen(path)
        if layer is None:
            raise RefusedFileError("is no USD that Pixar's library opens")
        if known is not None:
            known.Reload(force=True)
    named = _layers_named(layer)  # which are open until the stage has them
    stage = Usd.Stage.Open(layer, Usd.Stage.LoadAll)
    del named
    return stage


def _layers_named(root: Sdf.Layer) -> list[Sdf.Layer]:
    """The layer and those that it names, directly or not."""
    found, seen = [root], {root.identifier}
    for layer in found:
        for name in layer.GetCompositionAssetDependencies():
            place = layer.ComputeAbsolutePath(name)
            if place not in seen:
                seen.add(place)
                inner = layer_of_text(place) or Sdf.Layer.FindOrOpen(place)
                found += [] if inner is None else [inner]
    return found


def layers_of(stage: Usd.Stage) -> list[str]:
    """Paths of the files of a stage, and of those that it names and are not found."""
    layers = [layer.realPath.partition("[")[0] for layer in stage.GetUsedLayers(includeClipLayers=True)]
    errors = [getattr(error, "resolvedAssetPath", "") or "" for error in stage.GetCompositionErrors()]
    return sorted({path for path in (*layers, *errors) if path})
