"""`off`: strands have no shadows."""

from __future__ import annotations

from ..shadow_model import ShadowModel


class Off(ShadowModel):
    """No shadow map."""

    name = "off"


DRIVER = Off()
