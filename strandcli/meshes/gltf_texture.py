"""The picture that colours the meshes of a glTF file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..exchange.beside import picture
from ..exchange.gltf_file import Gltf
from .make import RawMesh

COLOURS = (
    ("pbrMetallicRoughness", "baseColorTexture"),
    ("extensions", "KHR_materials_pbrSpecularGlossiness", "diffuseTexture"),
)
"""Where a material may name the picture of its colour."""
WEBP = "EXT_texture_webp"


def texture_of(file: Gltf, primitive: dict[str, Any]) -> dict[str, Any]:
    """How a primitive's material names the picture of its colour; empty where it has none."""
    if "material" not in primitive:
        return {}
    material = file.named("materials", primitive["material"], "material")
    for path in COLOURS:
        found: Any = material
        for name in path:
            found = found.get(name) if isinstance(found, dict) else None
        if isinstance(found, dict):
            return found
    return {}


def with_texture(file: Gltf, part: RawMesh, primitives: list[dict[str, Any]]) -> RawMesh:
    """A part with the first picture that primitives have, which alone is decoded, once. A note tells where others have
    another one, or one of a kind that is not read. Raises `UsageError` for one that is no picture."""
    images = []
    for one in primitives:
        named = texture_of(file, one)
        if named:
            texture = file.named("textures", named.get("index"), "material")
            extensions = texture.get("extensions")
            webp = extensions.get(WEBP) if isinstance(extensions, dict) else None
            images.append((webp if isinstance(webp, dict) else texture).get("source"))
    notes, found = [], None
    for index in dict.fromkeys(images):
        if index is None:
            notes.append("a texture of a kind that is not read; save it as PNG or JPEG")
        elif found is None:
            image, where = file.named("images", index, "texture"), f"images[{index}]"
            content = file.content(image["uri"], where) if "uri" in image else file.view(image.get("bufferView"), where)
            found = picture(bytes(content))
            if found is None:
                raise file.fault(where, "is no picture that can be read, such as PNG or JPEG")
    if len(set(images)) > 1:
        notes.append(f"{len(set(images))} textures: the first is taken for all of it")
    return replace(part, texture=found, notes=(*part.notes, *notes))
