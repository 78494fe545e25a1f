from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from moving import at, down
from on_table import on_table

from topple.benchmarks.grasps import random_grasps
from topple.benchmarks.plain_hands import against, held
from topple.planner.grasp.foreign import ForeignGrasps, grasps_from_array
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.jaw import hand_shape
from topple.planner.grasp.rank import camera_frame, rank_all, rank_grasps
from topple.planner.grasp.suction import cup_shape
from topple.planner.planning.order import order
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.io import load_scene
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage


def scene() -> Scene:
    places = {"lower": (0.0, 0.0, 0.0), "upper": (0.0, 0.0, 0.0505)}
    return on_table(*((box(name, (0.05, 0.05, 0.05)), at) for name, at in places.items()), half=0.3)


GRASPS = np.array([down(0.0, 0.0, 0.035), down(0.0, 0.0, 0.088), down(0.2, 0.2, 0.1)])


def test_what_may_go_first_comes_first_whatever_the_scores():
    ranked = rank_grasps(scene(), GRASPS)
    assert [entry.grasp.object for entry in ranked] == ["upper", "lower", ""]
    assert ranked[0].why is None
    assert ranked[0].before == ()


def test_every_dropped_grasp_says_why():
    ranked = {entry.index: entry for entry in rank_grasps(scene(), GRASPS)}
    assert "upper" in (ranked[0].why or "")
    assert ranked[2].why == "nothing is between its pads"


@pytest.mark.parametrize(
    ("mass", "why"),
    [
        (4.0, ["4 kg are more than panda carries (2.27 kg beside its hand)"]),
        (30.0, ["30 kg are more than the pads hold", "30 kg are more than panda carries"]),
        (2.0, []),
    ],
)
def test_what_is_known_to_weigh_more_than_hand_or_arm_hold_is_refused_with_its_figures(mass, why):
    upper = rank_grasps(scene().weighed({"upper": mass}), GRASPS, "panda")[0]
    assert upper.grasp.object == "upper"
    said = (upper.why or "").split("; ")
    assert [words for words in why if not any(words in each for each in said)] == []
    assert (upper.why is None) is not bool(why)


def test_what_the_arm_cannot_reach_is_dropped():
    far = at(-3.0, 0.0, 0.0)
    ranked = rank_grasps(scene(), GRASPS, robot("panda"), pose_base_to_world=far)
    assert ranked[0].why == "out of reach"


def test_grasps_in_the_frame_of_the_scene_s_camera_are_taken_by_its_pose():
    eye = down(0.1, 0.0, 0.9)
    depth, label = np.full((120, 160), 0.9), np.zeros((120, 160), np.int64)
    camera = DepthImage(depth, np.array([[150.0, 0, 80], [0, 150, 60], [0, 0, 1]]), label, eye)
    seen = Scene(scene().clouds, ["table"], (0, 0, 1), images=[camera])
    poses = np.linalg.inv(eye) @ GRASPS
    known = grasps_from_array(GRASPS)
    assert camera_frame(seen, known) is None
    assert camera_frame(seen, replace(known, poses_tool_to_source=poses)) == pytest.approx(eye)
    ranked = [[(entry.index, entry.why) for entry in rank_grasps(seen, some)] for some in (GRASPS, poses)]
    assert ranked[0] == ranked[1]
    with pytest.raises(InvalidInput, match="no grasp is near anything"):
        rank_grasps(scene(), poses)


def test_no_grasps_give_no_ranking():
    assert rank_grasps(scene(), np.empty((0, 4, 4))) == []


def test_all_that_speaks_against_a_grasp_is_said():
    ranked = {entry.index: entry for entry in rank_grasps(scene(), GRASPS)}
    assert "the hand meets upper" in (ranked[0].why or "")
    assert "upper would move: has to go before lower" in (ranked[0].why or "")


def test_of_what_may_go_now_what_can_be_done_comes_before_a_better_score():
    blocked, free = down(0.0, 0.0, 0.088), down(0.0, 0.0, 0.088)
    blocked[2, 3] = 0.03  # so deep that the palm meets the top
    poses = [
        Grasp("upper", "pinch", pose, 0.05, 0.06, score) for pose, score in ((blocked, 0.9), (free, 0.2))
    ]
    better = replace(poses[1], score=0.3)
    ranked = rank_grasps(scene(), [*poses, better])
    assert [entry.index for entry in ranked] == [2, 1, 0]
    assert ranked[2].why is not None


def test_grasps_in_another_frame_are_brought_to_the_world_or_refused():
    away, back = np.eye(4), np.eye(4)
    away[0, 3], back[0, 3] = 2.0, -2.0
    with pytest.raises(InvalidInput, match=r"no grasp is near anything.*pose_source_to_world"):
        rank_grasps(scene(), away @ GRASPS)
    ranked = rank_grasps(scene(), away @ GRASPS, pose_source_to_world=back)
    assert [entry.grasp.object for entry in ranked] == ["upper", "lower", ""]
    with pytest.raises(InvalidInput, match="pose_source_to_world"):
        rank_grasps(scene(), GRASPS, pose_source_to_world=np.eye(3))


def test_grasps_of_what_is_not_there_and_by_tools_that_are_missing_are_refused():
    with pytest.raises(UnknownObject, match="cup"):
        rank_grasps(scene(), [Grasp("cup", "pinch", down(0.0, 0.0, 0.088), 0.05, 0.06, 1.0)])
    with pytest.raises(InvalidInput, match="panda has no suction"):
        rank_grasps(scene(), [Grasp("upper", "suction", down(0.0, 0.0, 0.1), 0.0, 0.0, 1.0)], "panda")


def test_a_cup_that_meets_a_neighbour_says_which():
    beside = box("wall", (0.02, 0.05, 0.2)).surface(3000, np.random.default_rng(1)) + np.array(
        [0.02, 0.0, 0.0]
    )
    pushed = scene().with_cloud("wall", beside)
    grasp = Grasp("upper", "suction", down(0.0, 0.0, 0.1005), 0.0, 0.08, 0.9)
    met, free = (rank_grasps(given, [grasp], "panda-suction")[0] for given in (pushed, scene()))
    assert "the hand meets wall" in (met.why or "")
    assert free.why is None


def test_a_neighbour_beside_the_cup_alone_is_met_too():
    cup = cup_shape(robot("panda-suction"))
    rod = np.random.default_rng(1).uniform([-0.003, -0.003, 0.103], [0.003, 0.003, 0.12], (400, 3))
    rod += np.array([0.012, 0.0, 0.0])
    assert all(rod[:, 2].max() < 0.1005 - prism.front for prism in cup.body), "under the open fingers"
    grasp = Grasp("upper", "suction", down(0.0, 0.0, 0.1005), 0.0, 0.08, 0.9)
    (ranked,) = rank_grasps(scene().with_cloud("rod", rod), [grasp], "panda-suction")
    assert "the hand meets rod" in (ranked.why or "")


WAYS = ("the hand meets", "the fingers would")
"""How the words begin that a plain search for what is in the way has as well."""

JUDGED = ("a finger would stand in", "pads would slide off", "nothing of")
"""How those begin that it has not, beside the widths."""

FRAMES = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "rgbd"


def frame(name: str) -> Scene:
    path = FRAMES / f"{name}.npz"
    if not path.exists():
        pytest.skip(f"the real frame {path.name} is not there")
    return load_scene(path)


def one_by_one(
    given: Scene, poses: np.ndarray, arm: str | None, base: np.ndarray | None
) -> list[tuple[object, ...]]:
    """The ranking in plain numpy, every grasp for itself; inverse kinematics asked for all states."""
    hand, cup = hand_shape(robot(arm or "panda")), cup_shape(robot("panda-suction"))
    graph, found = order(given).graph, []
    for index, pose in enumerate(poses):
        grasp = Grasp("", "pinch", pose, 0.0, 0.0, 1.0)
        grasp = replace(grasp, object=held(grasp, given, hand))
        name = grasp.object
        before = tuple(sorted(graph.before(name))) if name else ()
        why = against(grasp, given, hand, cup) if name else "nothing is between its pads"
        wait = f"{', '.join(before)} would move: has to go before {name}" if before else ""
        found.append((index, name, before, "; ".join(filter(None, (why, wait)))))
    free = [entry[0] for entry in found if not entry[3]]
    if arm is not None and base is not None and free:
        both = np.stack([poses[free], poses[free] @ np.diag([-1.0, -1.0, 1.0, 1.0])], axis=1)
        states = robot(arm).inverse(np.linalg.inv(base) @ both.reshape(-1, 4, 4))
        far = {index for k, index in enumerate(free) if not (len(states[2 * k]) or len(states[2 * k + 1]))}
        found = [(*entry[:3], "out of reach") if entry[0] in far else entry for entry in found]
    return sorted(found, key=lambda entry: (len(entry[2]) if entry[1] else np.inf, bool(entry[3]), entry[0]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "arm"),
    [("osd_test42", "panda"), ("osd_test60", "iiwa"), ("osd_learn33", None)],
)
def test_many_grasps_of_a_real_frame_are_ranked_as_each_by_itself(name, arm):
    given = frame(name)
    poses = random_grasps(given, 40, np.random.default_rng(2))
    up = np.asarray(given.up)
    ahead = np.cross(up, [0.0, 0.3, 1.0])
    ahead /= np.linalg.norm(ahead)
    base = np.eye(4)
    base[:3, :3] = np.column_stack([ahead, np.cross(up, ahead), up])
    base[:3, 3] = poses[:, :3, 3].mean(axis=0) - 0.8 * base[:3, 0]  # some are out of reach
    ranked = rank_grasps(given, poses, arm, pose_base_to_world=base)
    told = {entry.index: (entry.grasp.object, entry.before, entry.why or "") for entry in ranked}
    for index, name, before, why in one_by_one(given, poses, arm, base):
        held, waits, said = told[index]
        more = [text for text in said.split("; ") if text not in why]
        assert (held, waits) == (name, before)
        assert why in ("out of reach", "") or all(text in said for text in why.split("; "))
        assert all(text.startswith(JUDGED) or "wide between the pads" in text for text in filter(None, more))
    assert all(np.array_equal(entry.grasp.pose_tool_to_world, poses[entry.index]) for entry in ranked)


def test_many_cups_among_neighbours_are_told_what_each_by_itself_is_told():
    given, rng = scene(), np.random.default_rng(3)
    poses = random_grasps(given, 60, rng)
    names = [given.movable[int(rng.integers(len(given.movable)))] for _ in poses]
    cups = [Grasp(name, "suction", pose, 0.0, 0.08, 0.5) for name, pose in zip(names, poses, strict=True)]
    hand, cup = hand_shape(robot("panda")), cup_shape(robot("panda-suction"))
    ranked = {entry.index: entry for entry in rank_grasps(given, cups)}
    met = [against(grasp, given, hand, cup) for grasp in cups]
    assert len(set(met)) > 3
    for index, words in enumerate(met):
        told = (ranked[index].why or "").split("; ")
        assert "; ".join(text for text in told if text.startswith(WAYS)) == words


def test_what_a_file_calls_things_is_what_they_hold_and_what_it_names_wrongly_says_so():
    given = Scene(
        {"7" if n == "upper" else "3" if n == "lower" else n: c for n, c in scene().clouds.items()},
        fixed=["table"],
        up=[0, 0, 1],
    )
    poses = np.array([down(0.0, 0.0, 0.088)] * 4)

    def labelled(*labels: str) -> ForeignGrasps:
        return ForeignGrasps(poses, np.ones(4), np.full(4, np.nan), "contact_graspnet", labels)

    told = {entry.index: entry for entry in rank_grasps(given, labelled("7", "3", "12", ""))}
    assert [told[index].grasp.object for index in range(4)] == ["7", "", "", "7"]
    assert told[0].why is None
    assert told[1].why == "its file has it hold 3, but between its pads is 7"
    assert told[2].why == "its file has it hold 12, which is not in the scene"
    unlabelled = rank_grasps(given, labelled("40", "41", "42", "43"))
    assert {entry.grasp.object for entry in unlabelled} == {"7"}, "numbers of other things mean nothing here"
    named = {
        entry.index: entry
        for entry in rank_grasps(given, labelled("6", "6", "2", "2"), names={6: "7", 2: "3"})
    }
    assert [named[index].grasp.object for index in range(4)] == ["7", "7", "", ""]
    with pytest.raises(UnknownObject, match="cup"):
        rank_grasps(given, labelled("6", "6", "2", "2"), names={6: "cup"})


def test_a_reach_of_ones_own_is_asked_about_what_nothing_else_speaks_against():
    asked: list[list[str]] = []

    def reach(grasps):
        asked.append([grasp.object for grasp in grasps])
        return ["joint 4 at its limit" for _ in grasps]

    ranked = {entry.index: entry for entry in rank_grasps(scene(), GRASPS, reach=reach)}
    assert asked == [["upper"]]
    assert ranked[1].why == "joint 4 at its limit"
    assert "out of reach" not in (ranked[0].why or "") and ranked[2].why == "nothing is between its pads"
    everywhere = rank_grasps(scene(), GRASPS, reach=lambda grasps: [True] * len(grasps))
    nowhere = rank_grasps(scene(), GRASPS, reach=lambda grasps: np.zeros(len(grasps), bool))
    assert (everywhere[0].why, nowhere[0].why) == (None, "out of reach")


def test_a_reach_of_ones_own_goes_before_the_arms(tmp_path):
    far = at(-3.0, 0.0, 0.0)
    ranked = rank_grasps(scene(), GRASPS, "panda", pose_base_to_world=far, reach=lambda grasps: [True])
    assert ranked[0].why is None


@pytest.mark.parametrize(
    ("answers", "words"), [([], "0 answers for 1 grasps"), ([0.5], "reach gave 0.5 for a grasp")]
)
def test_a_reach_that_answers_something_else_is_refused(answers, words):
    with pytest.raises(InvalidInput, match=words):
        rank_grasps(scene(), GRASPS, reach=lambda grasps: answers)


def test_many_scenes_are_ranked_as_each_by_itself():
    turned = GRASPS[::-1]
    with ThreadPoolExecutor(2) as executor:
        batch = rank_all([scene(), scene()], [GRASPS, turned], executor=executor)
    assert batch == [rank_grasps(scene(), GRASPS), rank_grasps(scene(), turned)]
    with pytest.raises(InvalidInput, match="scenes and grasps differ in number from 1 on"):
        rank_all([scene(), scene()], [GRASPS])
