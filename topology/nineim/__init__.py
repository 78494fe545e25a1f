"""The 9-intersection model (DE-9IM) on complete solids, a peer of the 6-intersection model."""
