"""An `.npz` of clouds: one array (N, 3) per object under the object's name."""

from collections.abc import Collection, Mapping

import numpy as np

from topple.topology.base.errors import InvalidInput
from topple.topology.io.archive import Array
from topple.topology.io.assemble import Parts
from topple.topology.io.strict_json import read_json
from topple.topology.scene.write import BY_NAME, OWN


def parts_from_clouds(arrays: Mapping[str, Array]) -> Parts:
    """Take clouds and the optional keys apart.

    Args:
        arrays: The file's arrays: points (N, 3) in [m] per object; optional `up` (3,), `fixed`
            (names), `viewpoints` (k, 3), `table_plane` (4,), `robot_base` (4, 4), `matter` (N, 3), what is
            in the way and no object, and as JSON text, which no cloud is, `masses` {name: kg},
            `friction` {name: coefficient} and `centres` {name: [x, y, z]} of mass [m].

    Returns:
        What the file says. Other text is a note, not an object, and is left out.

    Raises:
        InvalidInput: If `fixed` does not hold names, or `masses`, `friction` or `centres` are no text and
            no cloud.
    """
    clouds = {
        name: array for name, array in arrays.items() if name not in OWN and array.dtype.kind not in "US"
    }
    masses, friction, centres = (amounts_in(arrays, key) for key in ("masses", "friction", "centres"))
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
        matter=arrays.get("matter"),
        masses=masses,
        friction=friction,
        centres=centres,
        notes=note_unused(arrays, {*clouds, *OWN, *BY_NAME}),
    )


def amounts_in(arrays: Mapping[str, Array], key: str) -> object:
    """Read amounts by name: numpy.savez(file, masses=json.dumps({"mug": 0.35}), ...).

    Args:
        arrays: The file's arrays.
        key: `masses`, `friction` or `centres`.

    Returns:
        What the text says, not yet checked; None where there is none. An array (N, 3) of numbers is the cloud
        of an object of that name.

    Raises:
        InvalidInput: If the array is anything else, or its text is not JSON.
    """
    array = arrays.get(key)
    if array is None or (array.ndim == 2 and array.dtype.kind not in "US"):
        return None
    if array.size != 1 or array.dtype.kind not in "US":
        raise InvalidInput(
            f"{key} is an array {array.shape} of {array.dtype}, which names no object: expected JSON text, "
            f"{key}=json.dumps({BY_NAME[key]})"
        )
    (text,) = names_in(array)
    return read_json(text, key)


def note_unused(arrays: Mapping[str, Array], used: Collection[str]) -> list[str]:
    """The note on the arrays of a file that were not used, if there are any."""
    left = sorted(set(arrays).difference(used))
    return [f"not used, being unknown: the array{'s' * (len(left) > 1)} {', '.join(left)}"] if left else []


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
    try:
        values: list[object] = np.ravel(array).tolist()
    except (SystemError, ValueError) as error:  # numbers that stand for no letter
        raise InvalidInput(f"an array of {array.dtype} holds what is no text: expected names") from error
    return [value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value) for value in values]
