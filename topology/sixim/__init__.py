"""The 6-intersection model: Table 1, pairs and their table, the paper's rule, and a fast version of it."""
