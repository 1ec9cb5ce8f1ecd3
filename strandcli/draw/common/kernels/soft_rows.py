"""Rows of a batch in which shadows of solids in a light with a size are worked out (`soft_shadows`)."""

from __future__ import annotations

from .layout import layout

# Of a point: sine of the light's angular radius, that of the least angle from the light's middle to an
# edge, and whether a solid is asked.
RADIUS, LEAST, ASKED = layout.take("soft shadow", 3, strands="soft", surfaces="soft")
# Of one that is listed: its number, the way from it to the beginning of the axis, direction and distance of the light;
# of a search its ends, the places between, and what is found there. All these are moved together, row by row.
LIST, WX, WY, WZ, DX, DY, DZ, END = layout.take("listed points", 8, strands="soft", surfaces="soft")
LOW, HIGH, NEAR, FAR, AT_NEAR, AT_FAR = layout.take("search along an axis", 6, strands="soft", surfaces="soft")
