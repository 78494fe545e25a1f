"""Where the models of the arms are: they come with PyBullet, the Panda's with robosuite as well."""

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from topple.topology.base.errors import NotInstalled

ROBOSUITE = "robosuite", "robosuite/models/assets/bullet_data/panda_description/urdf/panda_arm_hand.urdf"
"""A distribution for every Python, and the Panda in it: links, joints and meshes are those of PyBullet's."""


def data_path() -> Path:
    """The folder of pybullet_data, which carries the arms' models.

    Raises:
        NotInstalled: PyBullet is not installed; `robot` then takes URDF files alone.
    """
    try:
        import pybullet_data
    except ModuleNotFoundError as error:
        words = (
            "this arm's model comes with PyBullet, the Panda's with robosuite as well (pip install --no-deps "
            "robosuite), others as FILE.urdf"
        )
        raise NotInstalled(words, "sim") from error
    return Path(pybullet_data.getDataPath())


def panda_file() -> Path:
    """The Panda's URDF, from whichever package is installed; of robosuite the file alone is read.

    Raises:
        NotInstalled: Neither is.
    """
    try:
        return data_path() / "franka_panda" / "panda.urdf"
    except NotInstalled:
        try:
            found = Path(str(distribution(ROBOSUITE[0]).locate_file(ROBOSUITE[1])))
        except PackageNotFoundError:
            found = None
        if found is None or not found.is_file():
            raise
        return found
