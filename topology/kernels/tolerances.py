"""Numbers of the kernels and their twins, each with its unit and reason, by the kernel that asks them."""

# -- spheres

ROUNDS = 12
"""Steps of least squares: a fit of half a ball is still after five."""

STILL = 1e-8
"""Step [m] of a fit that changes nothing any more: less than what a float32 cloud tells."""

# -- continued

BORDER = 4
"""Pixels that the border of a mask may be off: what registration and a good segmentation come to, twice."""

FAR = 2 * BORDER + 1
"""Pixels from a wrong pixel to the inside of the mask that it is of, at most."""

NOBODY = -1
"""Owner of a pixel that flies between two surfaces."""

NO_SURFACE = -2
"""Label of a pixel of which no surface is continued."""

AROUND = ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, -1), (1, -1), (-1, 1))
"""Rows and columns to the pixels beside one."""

NEAREST = 1e-3
"""Depth [m] below which a pixel counts as this near, and inverse depth [1/m] that counts as far: no camera
sees so near or so far."""

PATCH = 7
"""Pixels along the side of the patch that a surface is continued from: a few of noise are averaged out."""

NARROW = 0.3
"""[pixels^2] added to a patch's spread, so that one of a single row has no slope across it."""

OFF = 0.005
"""[m] at a metre and nearer, beyond with its square, that a pixel lies off the surface that it is of, at
most: above a depth camera's noise and steps, and what a surface bends within a few pixels."""

# -- cavity

LOOKED_ALONG = 1 << 14
"""Lines of sight looked along at once (0.4 MB): they stay in a core's own cache."""
