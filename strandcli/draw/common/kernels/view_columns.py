"""Columns of a view as kernels read it: (26,) float32, packed by `strandcli.draw.view.camera.View.pack`.

Three rows (right, up, forward), each a unit vector and a shift, take a point of the world to the view, metres.
"""

RIGHT_X, RIGHT_Y, RIGHT_Z, RIGHT_SHIFT = range(4)
UP_X, UP_Y, UP_Z, UP_SHIFT = range(4, 8)
FORWARD_X, FORWARD_Y, FORWARD_Z, FORWARD_SHIFT = range(8, 12)
PERSPECTIVE = 12
"""1 for a perspective view, 0 for an orthographic one."""
FOCAL = 13
"""Pixels a metre: at a depth of one metre (perspective) or anywhere (orthographic)."""
NEAR_PLANE = 14
"""Metres."""
AXIS_X, AXIS_Y = 15, 16
"""Pixel that the view's axis goes through."""
SLANT_X, SLANT_Y = 17, 18
"""How much further out a slanted side of the view lies for a margin of one."""
DEPTH_RANGE = 19
"""Far less near, metres."""
EYE_X, EYE_Y, EYE_Z = 20, 21, 22
"""Metres."""
CORNER_STRETCH = 23
"""How many times longer than in the middle of the screen a short way can be in its corner, at the same depth."""
SCREEN_WIDTH, SCREEN_HEIGHT = 24, 25
"""Pixels."""
SIZE = 26
