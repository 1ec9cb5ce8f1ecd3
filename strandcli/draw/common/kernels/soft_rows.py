"""Rows of a batch for the soft shadows of solids in lights with a size (`soft_shadows`)."""

from __future__ import annotations

from .layout import layout

# Of each point: sine of the light's angular radius, sine of the least angle between the light's centre and a solid's
# silhouette, and whether the current solid can shade it.
RADIUS, LEAST, ASKED = layout.allocate("soft shadow", 3, strands="soft", surfaces="soft")
# Of each listed point: its number, the vector to the beginning of the solid's axis, direction and distance of the
# light; and of the search along the axis the ends, the two places between, and the values there. Compaction moves all
# of these rows together.
LIST, WX, WY, WZ, DX, DY, DZ, END = layout.allocate("listed points", 8, strands="soft", surfaces="soft")
LOW, HIGH, NEAR, FAR, AT_NEAR, AT_FAR = layout.allocate("search along an axis", 6, strands="soft", surfaces="soft")
