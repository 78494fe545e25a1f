import numpy as np

from topple.planner import ForeignGrasps


def reads(path):
    return path.suffix == ".csv"


def read(path):  # lines of x, y, z, width [m]: from above
    rows = np.loadtxt(path, delimiter=",", ndmin=2)
    poses = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (len(rows), 1, 1))  # z approaches, y closes
    poses[:, :3, 3] = rows[:, :3]
    return ForeignGrasps(poses, np.ones(len(rows)), rows[:, 3], "csv")
