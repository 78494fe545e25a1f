"""The 6-intersection model: Table 1, the matrix of equations 1 to 4, the paper's whole rule."""
