"""A scene in one file: an `.npz` of clouds, a labelled cloud, or an RGB-D frame, told apart by its arrays."""

import os
from pathlib import Path

from topple.topology.io.archive import is_labelled, is_rgbd, read_arrays
from topple.topology.io.assemble import Parts
from topple.topology.io.clouds import parts_from_clouds
from topple.topology.io.labelled import parts_from_labelled
from topple.topology.io.pcd import is_pcd, read_labelled_pcd
from topple.topology.io.rgbd import parts_from_rgbd


def reads(path: Path) -> bool:
    """Any file is one: what none of the other readers knows is refused here, with what was expected."""
    return path.is_file()


def read(path: Path, masks: str | os.PathLike[str] | None = None) -> Parts:
    """Read the file.

    Args:
        path: The file.
        masks: Another one, with the masks of an RGB-D frame that has none, see `topple.topology.io.sam`.

    Returns:
        What it says.

    Raises:
        InvalidInput: If it holds no scene or a broken one.
        OSError: If it cannot be read.
    """
    arrays = read_labelled_pcd(path) if is_pcd(path) else read_arrays(path)
    if masks is not None:
        from topple.topology.io.sam import parts_from_sam, read_masks

        return parts_from_sam(arrays, read_masks(masks))
    if is_labelled(arrays):
        return parts_from_labelled(arrays)
    return parts_from_rgbd(arrays) if is_rgbd(arrays) else parts_from_clouds(arrays)
