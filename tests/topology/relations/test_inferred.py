import json
from pathlib import Path

import numpy as np
import pytest

from topple.topology.io import load_scene
from topple.topology.relations.inferred import floating_objects
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.sixim.confidence import Evidence, confidence
from topple.topology.sixim.table import Relation

SHARED = Path(__file__).resolve().parents[3].parent / "shared"
UP = np.array([0.0, 0, 1])
CAMERA = np.array([[0.0, -0.6, 0.8]])


def top_of_box(size, centre, seed=0):
    """What a camera above sees of a box: its top and the upper half of its front."""
    rng = np.random.default_rng(seed)
    flat = rng.uniform(-0.5, 0.5, (2000, 2)) * size[:2]
    front = rng.uniform([-0.5, 0.1], [0.5, 0.5], (1000, 2)) * [size[0], size[2]]
    top = np.c_[flat, np.full(2000, size[2] / 2)]
    side = np.c_[front[:, 0], np.full(1000, -size[1] / 2), front[:, 1]]
    return np.concatenate([top, side]) + centre


def table(seed=1):
    points = np.c_[np.random.default_rng(seed).uniform(-0.4, 0.4, (9000, 2)), np.zeros(9000)]
    hidden = (np.abs(points[:, 0]) < 0.05) & (points[:, 1] > -0.05) & (points[:, 1] < 0.12)
    return points[~hidden]


def scene(**options):
    box = top_of_box((0.1, 0.1, 0.06), [0, 0, 0.03])
    return Scene({"table": table(), "box": box}, fixed=["table"], viewpoints=CAMERA, **options)


def test_a_box_with_a_hidden_foot_touches_the_table_by_inference():
    pair = relate(scene(up=UP)).between("table", "box")
    assert pair.relation is Relation.TOUCH
    assert pair.inferred
    assert not pair.observed
    assert pair.gap > 0.01
    assert pair.matrix[:, :2].sum() == 0  # of the contact no point shows anything
    assert pair.reason == "inferred: it floats otherwise"
    assert pair.to_json()["reason"] == pair.reason
    (carried,) = Situation(scene(up=UP)).supports
    assert carried.inferred
    assert 0.5 < carried.confidence < 0.9
    assert pair.confidence == confidence(Evidence.FLOATS, 1), "as often as such a conclusion was true"


def test_a_lid_with_a_hidden_underside_touches_the_box_below_by_inference():
    low, lid = top_of_box((0.1, 0.1, 0.06), [0, 0, 0.03]), top_of_box((0.08, 0.08, 0.05), [0, 0, 0.085])
    stack = Scene(
        {"table": table(), "low": low, "lid": lid[lid[:, 2] > 0.075]},
        fixed=["table"],
        up=UP,
        viewpoints=CAMERA,
    )
    assert relate(stack, plain=True).between("lid", "low").relation is Relation.DISJOINT
    pair = relate(stack).between("lid", "low")
    assert pair.relation is Relation.TOUCH
    assert pair.inferred


def test_without_up_or_by_the_plain_rule_nothing_is_inferred():
    assert relate(scene()).between("table", "box").relation is Relation.DISJOINT
    assert not any(pair.inferred for pair in relate(scene(up=UP), plain=True).pairs)


def test_what_touches_something_below_does_not_float():
    box = top_of_box((0.1, 0.1, 0.06), [0, 0, 0.0])
    resting = Scene({"table": table(), "box": box}, fixed=["table"], up=UP)
    assert floating_objects(resting, relate(resting, plain=True)) == frozenset({"box"})
    relations = relate(resting, deviation=0.004)
    assert relations.between("table", "box").relation is Relation.TOUCH
    assert floating_objects(resting, relations) == frozenset()


def test_a_cup_held_far_above_the_table_is_not_put_down():
    held = Scene(
        {"table": table(), "cup": top_of_box((0.06, 0.06, 0.08), [0.2, 0, 0.4])},
        fixed=["table"],
        up=UP,
        viewpoints=CAMERA,
    )
    assert relate(held).between("table", "cup").relation is Relation.DISJOINT


@pytest.mark.skipif(not (SHARED / "data/rgbd").is_dir(), reason="the RGB-D scenes are not beside the project")
@pytest.mark.parametrize("name", ["osd_test43", "osd_test47"])
def test_hidden_contacts_of_real_scenes_are_inferred(name):
    truth = json.loads((SHARED / f"data/rgbd/{name}.gt.json").read_text())
    relations = relate(load_scene(SHARED / f"data/rgbd/{name}.npz", fixed=["1"]))
    assert truth["relations"]
    for a, b, relation in truth["relations"]:
        assert relations.between(str(a), str(b)).relation == relation


def test_what_only_leans_must_stand_on_something_else_besides():
    rng = np.random.default_rng(2)
    wall = np.c_[rng.uniform([-0.1, -0.05], [0.1, 0.0], (3000, 2)), np.full(3000, 0.08)]
    share = rng.uniform(0.3, 1.0, (3000, 1))  # of the board's length: its foot is hidden
    foot, top = np.array([0.0, 0.06, 0.0]), np.array([0.0, -0.03, 0.12])
    board = foot + share * (top - foot) + np.c_[rng.uniform(-0.04, 0.04, 3000), np.zeros((3000, 2))]
    clouds = {"table": table(), "box": wall, "board": board}
    leaning = Scene(clouds, fixed=["table"], up=UP, viewpoints=CAMERA)
    relations = relate(leaning, plain=True).with_pair(relate(leaning, 0.004).between("board", "box"))
    assert relations.between("board", "box").relation is Relation.TOUCH
    assert "board" in floating_objects(leaning, relations)
