"""The page of who reads what counts the lines that are there."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "benchmarks" / "readers.md").read_text(encoding="utf-8").splitlines()
SLACK = 0.1
"""Share that a count may be stale by: it is not written anew for every line."""

FILES = {
    "URDF": [f"robots/arm/{name}.py" for name in ("urdf", "elements", "shapes", "tree")],
    "SRDF": ["robots/arm/srdf.py"],
    "PCD": ["topology/io/pcd.py"],
    "PLY": ["topology/io/geometry.py"],
    "`.npz`": ["topology/io/archive.py"],
    "pictures": ["topology/io/picture.py"],
    "BOP": ["topology/io/bop.py"],
    "rosbag": ["topology/io/bag.py"],
    "folders of known models": ["topology/io/model_files.py"],
    "COCO": ["topology/io/coco.py"],
    "grasps": ["planner/grasp/foreign.py"],
    "labels": ["benchmarks/labels.py"],
    "Open3D": ["topology/io/objects.py"],
}


@pytest.mark.parametrize("row", FILES)
def test_the_page_counts_the_lines_of_a_reader(row):
    (line,) = [line for line in PAGE if line.startswith(f"| {row}")]
    said = int(line.split("|")[4])
    there = sum(len((ROOT / path).read_text(encoding="utf-8").splitlines()) for path in FILES[row])
    assert said == pytest.approx(there, rel=SLACK), f"{there} lines; write it into benchmarks/readers.md"
