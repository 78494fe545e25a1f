"""The 6-intersection model: Table 1, the paper's whole rule, and in `fast` the same answers sooner."""
