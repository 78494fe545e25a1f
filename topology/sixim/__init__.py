"""The 6-intersection model: Table 1, the paper's rule in full, and a fast version with the same answers."""
