"""Where the models that come with PyBullet are."""

from pathlib import Path

from topple.topology.errors import NotInstalled


def data_path() -> Path:
    """The folder of pybullet_data, which carries the arms' models.

    Raises:
        NotInstalled: PyBullet is not installed; `robot` then takes URDF files alone.
    """
    try:
        import pybullet_data
    except ModuleNotFoundError as error:
        raise NotInstalled("this arm's model comes with PyBullet, others as FILE.urdf", "sim") from error
    return Path(pybullet_data.getDataPath())
