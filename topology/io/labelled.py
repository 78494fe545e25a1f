"""One cloud of everything with a label per point: what segmentation gives a grasp pipeline."""

from collections.abc import Mapping

import numpy as np

from topple.topology.base.checks import numeric
from topple.topology.base.errors import InvalidInput
from topple.topology.io.archive import Array
from topple.topology.io.assemble import Parts
from topple.topology.io.clouds import note_unused
from topple.topology.io.labels import NAMING, fixed_labels, label_names
from topple.topology.scene.write import SPECIAL


def parts_from_labelled(arrays: Mapping[str, Array]) -> Parts:
    """Take the objects of a labelled cloud apart.

    Args:
        arrays: `points` (N, 3) in [m] and `labels` (N,), whole numbers with 0 = background; points with NaN
            or infinity are left out. Optional `names` and `ids` as with an RGB-D frame, and `up`, `fixed`
            (names or labels), `viewpoints`, `table_plane`, `robot_base`.

    Returns:
        What the file says, an object per label under its name or number.

    Raises:
        InvalidInput: If points and labels do not fit together, or there is no object.
    """
    points, labels = numeric(arrays["points"], "points"), arrays["labels"]
    if points.ndim != 2 or points.shape[1] != 3 or labels.shape != points.shape[:1]:
        raise InvalidInput(
            f"points has shape {points.shape} and labels {labels.shape}: expected (N, 3) and (N,), one label "
            "per point"
        )
    if labels.dtype.kind not in "iub" or (labels.size and labels.min() < 0):
        raise InvalidInput(f"labels holds {labels.dtype} values: expected whole numbers, 0 = background")
    seen = np.isfinite(points).all(axis=1)
    names = label_names(arrays, labels)
    present = [int(label) for label in np.unique(labels) if label > 0]
    if not present:
        raise InvalidInput("labels is 0 everywhere: expected labels from 1 on, one per object")
    called = [names.get(label, str(label)) for label in present]
    if len(set(called)) < len(called):
        raise InvalidInput(f"two labels share a name: {sorted(called)}; expected one name per label")
    by_label = np.flatnonzero(seen)[np.argsort(labels[seen], kind="stable")]
    bounds = [np.searchsorted(labels[by_label], present, side=side) for side in ("left", "right")]
    pieces = zip(called, bounds[0].tolist(), bounds[1].tolist(), strict=True)
    return Parts(
        clouds={name: points[by_label[first:end]] for name, first, end in pieces},
        fixed=fixed_labels(arrays, names),
        up=arrays.get("up"),
        viewpoints=arrays.get("viewpoints"),
        table_plane=arrays.get("table_plane"),
        robot_base=arrays.get("robot_base"),
        background=points[(labels == 0) & seen],
        notes=note_unused(arrays, ("points", "labels", *NAMING, *SPECIAL)),
    )
