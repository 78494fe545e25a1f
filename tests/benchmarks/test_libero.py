"""What is counted of others' scenes is what MuJoCo lets happen in them."""

from xml.etree import ElementTree

import numpy as np
import pytest

from topple.benchmarks.libero import fate, pairs_of, rows
from topple.benchmarks.peers.libero_scenes import without_missing, write
from topple.topology import InvalidInput

WORLD = """<mujoco><worldbody>
  <geom name="table" type="box" size="0.4 0.4 0.02" pos="0 0 -0.02"/>
  <body name="mug"><freejoint/><geom type="box" size="0.03 0.03 0.05"/></body>
  <body name="book"><freejoint/><geom type="box" size="0.1 0.1 0.01"/></body>
</worldbody></mujoco>"""


def state(mug: tuple[float, float, float], book: tuple[float, float, float]) -> np.ndarray:
    return np.array([*mug, 1, 0, 0, 0, *book, 1, 0, 0, 0], np.float64)


@pytest.mark.parametrize(("last", "share"), [((0.0, 0.0, 0.16), 100.0), ((0.0, 0.124, 0.07), 100.0)])
def test_verdicts_and_loads_of_scenes_are_held_against_simulation(tmp_path, last, share):
    book = (0.0, 0.0, 0.01)
    starts = [state((0.0, 0.0, 0.07), book), state((0.25, 0.1, 0.05), book), state(last, book)]
    write(ElementTree.fromstring(WORLD), starts, tmp_path / "task.xml", {})

    found = {row["what"]: row for row in rows(False, 0, lambda _: None, tmp_path)}
    moves = found["recall of what moves within 1 s"]
    assert (moves["tried"], moves["value"], moves["wrong"]) == (1, share, [])
    assert found["precision of what is said not to stand"]["tried"] == 1
    assert found["pairs at rest that carry: false or missed"]["held"] == 0
    assert found["pairs at rest that carry: false or missed"]["tried"] == 6  # mug and book, three times
    assert found["tasks that are read and checked"]["ok"]


def test_a_scene_that_is_refused_is_counted_and_an_empty_folder_refused(tmp_path):
    with pytest.raises(InvalidInput, match="libero needs --data DIR"):
        rows(False, 0, lambda _: None, tmp_path)
    (tmp_path / "task.json").write_text('{"states": [{"key": "state_0", "moved": {}}]}')
    (tmp_path / "task.xml").write_text(WORLD)  # which has no such keyframe
    read, *_, moves, _, _ = rows(False, 0, lambda _: None, tmp_path)
    assert (read["held"], read["ok"]) == (0, False)
    assert "no keyframe state_0" in moves["wrong"][0]


def test_what_stays_stands_and_what_only_touches_carries_nothing():
    assert [fate(each) for each in ((0.5, 0.2), (4.0, 0.0), (11.0, 0.0), (0.0, 12.0))] == [
        True,
        None,
        False,
        False,
    ]
    assert pairs_of([("mug", "table", 3.0), ("mug", "book", 0.02), ("book", "table", 2.0)]) == {
        frozenset(("mug", "table")),
        frozenset(("book", "table")),
    }


def test_of_files_that_are_not_there_only_what_is_looked_at_is_left_out():
    asset = '<asset><mesh name="m" file="/no/such.msh"/></asset>'
    geom = '<geom name="g" type="mesh" mesh="m" contype="0" conaffinity="0"/>'
    seen = f"<mujoco>{asset}<worldbody>{geom}</worldbody></mujoco>"
    assert b"no/such" not in without_missing(seen).encode()
    with pytest.raises(FileNotFoundError, match="can be touched"):
        without_missing(seen.replace('contype="0"', ""))
