"""A recorded pile: one settled scene as whole surfaces and as cameras saw it, with what had to go first."""

import zipfile
from pathlib import Path

from topple.topology.base.errors import InvalidInput
from topple.topology.io.archive import read_arrays
from topple.topology.io.assemble import Parts
from topple.topology.io.clouds import names_in

STEPS = 1e4
"""Steps of the stored clouds in a metre."""
VIEWS = {"full": None, "view1": "viewpoints1", "view3": "viewpoints3"}
"""The clouds there may be: whole surfaces, of one camera, of three -> the array of the cameras' places."""


def reads(path: Path) -> bool:
    """Tell an archive with clouds `full/NAME`, `view1/NAME` or `view3/NAME` beside `labels`."""
    if not path.is_file() or not zipfile.is_zipfile(path):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except (OSError, ValueError, zipfile.BadZipFile):
        return False
    return "labels.npy" in names and any(name.startswith(f"{view}/") for name in names for view in VIEWS)


def read(path: Path, view: str = "full") -> Parts:
    """Read one view of the pile.

    Args:
        path: The archive: clouds `VIEW/NAME` of whole numbers in tenths of millimetres, `up`, `fixed`,
            `viewpoints1`, `viewpoints3`, and `labels`, which is no part of the scene.
        view: "full" for whole surfaces, "view1" or "view3" for what one or three cameras saw.

    Returns:
        What the view shows, in [m].

    Raises:
        InvalidInput: There is no such view, or the archive is broken.
        OSError: If the file cannot be read.
    """
    arrays, prefix = read_arrays(path), f"{view}/"
    clouds = {key.removeprefix(prefix): array for key, array in arrays.items() if key.startswith(prefix)}
    if view not in VIEWS or not clouds:
        there = [name for name in VIEWS if any(key.startswith(f"{name}/") for key in arrays)]
        raise InvalidInput(f"the pile has no view {view!r}: expected {', '.join(there)}")
    for name, cloud in clouds.items():
        if cloud.dtype.kind not in "iu":
            raise InvalidInput(f"cloud {name!r} holds {cloud.dtype}: expected whole tenths of millimetres")
    return Parts(
        clouds={name: cloud / STEPS for name, cloud in clouds.items()},
        fixed=names_in(arrays["fixed"]) if "fixed" in arrays else [],
        up=arrays.get("up"),
        viewpoints=arrays.get(VIEWS[view] or ""),
    )
