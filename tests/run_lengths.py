"""Run lengths of masks, as COCO and SAM count them."""

import numpy as np


def lengths(mask: np.ndarray) -> list[int]:
    """Lengths of the runs of a mask (H, W), down its columns, zeros first."""
    flat = np.concatenate([[False], mask.T.ravel()])
    return np.diff([0, *np.flatnonzero(np.diff(flat)), mask.size]).tolist()
