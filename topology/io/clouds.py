"""An `.npz` of clouds: one array (N, 3) per object under the object's name."""

from collections.abc import Mapping

import numpy as np

from topple.topology.errors import InvalidInput
from topple.topology.io.archive import Array
from topple.topology.io.assemble import Parts

_SPECIAL = ("up", "fixed", "viewpoints", "table_plane", "robot_base")


def parts_from_clouds(arrays: Mapping[str, Array]) -> Parts:
    """Take clouds and the optional keys apart.

    Args:
        arrays: The file's arrays: points (N, 3) in [m] per object; optional `up` (3,), `fixed`
            (names), `viewpoints` (k, 3), `table_plane` (4,), `robot_base` (4, 4).

    Returns:
        What the file says. Text that is no `fixed` is a note, not an object, and is left out.

    Raises:
        InvalidInput: If `fixed` does not hold names.
    """
    clouds = {
        name: array for name, array in arrays.items() if name not in _SPECIAL and array.dtype.kind not in "US"
    }
    if not clouds:
        raise InvalidInput(
            f"no clouds found among the arrays {sorted(arrays)}: expected points (N, 3) under each object's "
            "name, or depth, K and label of an RGB-D frame"
        )
    return Parts(
        clouds=dict(clouds),
        fixed=names_in(arrays["fixed"]) if "fixed" in arrays else [],
        up=arrays.get("up"),
        viewpoints=arrays.get("viewpoints"),
        table_plane=arrays.get("table_plane"),
        robot_base=arrays.get("robot_base"),
    )


def names_in(array: Array) -> list[str]:
    """Read names.

    Args:
        array: Text, of any shape; whole numbers are names too, since masks name objects by label.

    Returns:
        The names.

    Raises:
        InvalidInput: If the array holds something else.
    """
    if array.size and array.dtype.kind not in "USiu":
        raise InvalidInput(
            f"fixed holds {array.dtype} values: expected names of objects, numpy.array(['table'])"
        )
    if array.dtype.kind == "S":
        return [value.decode("utf-8", "replace") for value in np.ravel(array).tolist()]
    return [str(value) for value in np.ravel(array).tolist()]
