from pathlib import Path

import pybullet_data

from topple.robots import robot


def arm():  # Arm.from_urdf and a Tool say more of it
    return robot(Path(pybullet_data.getDataPath()) / "franka_panda" / "panda.urdf")
