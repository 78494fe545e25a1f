import csv

from topple.topology import Parts


def reads(path):
    return path.suffix == ".csv"


def read(path):  # lines of name, x, y, z [m]
    clouds = {}
    for name, *point in csv.reader(path.read_text().splitlines()):
        clouds.setdefault(name, []).append([float(value) for value in point])
    return Parts(clouds=clouds, up=[0, 0, 1])
