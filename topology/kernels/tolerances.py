"""When a fit is done: numbers of the kernels and their twins."""

ROUNDS = 12
"""Steps of least squares: a fit of half a ball is still after five."""

STILL = 1e-8
"""Step [m] of a fit that changes nothing any more: less than what a float32 cloud tells."""
