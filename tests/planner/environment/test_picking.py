"""Environments of Gymnasium: what they show, what they reward, and that Gymnasium takes them."""

import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import topple.planner.environment  # registers them
from topple.planner.environment.picking import SLOTS, Picking
from topple.planner.environment.tolerances import EFFORT
from topple.topology.base.errors import InvalidInput
from topple.topology.sixim.table import Relation

DISHES = 0
"""A scene of which a plate carries all else."""


@pytest.fixture(scope="module")
def started():
    """The environment, its first observation, and the slot of each object."""
    made = gymnasium.make("topple/Dishes-v0", render_mode="rgb_array")
    observation, info = made.reset(seed=3, options={"scene": DISHES})
    yield made, observation, {name: slot for slot, name in enumerate(info["names"])}, info
    made.close()


def test_all_three_are_registered():
    assert topple.planner.environment
    for name in ("Pile", "Dishes", "Lemon"):
        assert gymnasium.spec(f"topple/{name}-v0").kwargs == {"scenario": name.lower()}


def test_the_arrays_say_what_relate_and_order_say(started):
    made, seen, slot, info = started
    assert info["goal"] == "free plate" and made.observation_space.contains(seen)
    assert np.flatnonzero(seen["target"]).tolist() == [slot["plate"]]
    assert sorted(np.flatnonzero(seen["action_mask"]).tolist()) == sorted(slot.values())
    names, spoon, plate = list(Relation), slot["spoon_1"], slot["plate"]
    assert names[int(seen["relations"][spoon, plate].argmax())] in ("within", "partial within", "touch")
    assert names[int(seen["relations"][plate, spoon].argmax())] in ("contain", "partial contain", "touch")
    assert (seen["relations"][: len(slot), : len(slot)].sum(axis=2) + np.eye(len(slot)) == 1).all()
    assert seen["graph"][spoon, plate] > 0.5 > seen["graph"][plate, spoon] == 0
    assert 0.15 < seen["objects"][plate, 3:5].min() < 0.35  # the plate's width [m]
    assert not seen["objects"][len(slot) :].any() and not seen["relations"][len(slot) :].any()
    picture = made.render()
    assert picture.shape == (480, 640, 3) and picture.dtype == np.uint8 and np.ptp(picture) > 100


def test_taking_the_plate_from_under_the_rest_costs_more_than_it_gains(started):
    made, _, slot, _ = started
    made.reset(seed=3, options={"scene": DISHES})
    _, reward, ended, cut, info = made.step(slot["plate"])
    assert info["reached"] and ended and not cut
    assert len(info["disturbed"]) >= 2 and reward == pytest.approx(1 - EFFORT - len(info["disturbed"]))


def test_one_after_the_other_the_plate_comes_free(started):
    made, seen, slot, _ = started
    made.reset(seed=3, options={"scene": DISHES})
    graph, rewards, taken = seen["graph"], [], set()
    while len(taken) < len(slot):
        now = next(name for name, k in slot.items() if name not in taken and not graph[:, k].any())
        seen, reward, ended, _, info = made.step(slot[now])
        assert info["object"] == now and not seen["action_mask"][slot[now]]
        taken.add(now)
        graph = seen["graph"]
        rewards.append(reward)
        assert ended == (now == "plate")
    assert rewards == pytest.approx([-EFFORT] * 4 + [1 - EFFORT])


def test_what_may_not_be_taken_does_nothing_and_ends_some_day(started):
    made, _, slot, _ = started
    made.reset(seed=3, options={"scene": DISHES})
    for step in range(3 * len(slot)):
        _, reward, ended, cut, info = made.step(SLOTS - 1)
        assert reward == -EFFORT and info["object"] is None and not ended
        assert cut == (step == 3 * len(slot) - 1)


def test_what_the_goal_puts_is_put_and_what_it_puts_it_on_stays():
    made = Picking("tower", slots=4, points=16)
    seen, info = made.reset(seed=0)
    slot = {name: k for k, name in enumerate(info["names"])}
    assert info["goal"] == "red on green on blue" and seen["clouds"].shape == (4, 16, 3)
    assert not seen["action_mask"][slot["blue"]] and seen["action_mask"][slot["red"]]
    made.close()
    with pytest.raises(InvalidInput, match="has 4 objects: give slots=4"):
        Picking("tower", slots=3).reset(seed=0)


def test_arguments_that_make_no_sense_are_refused():
    for wrong in ({"cameras": 4}, {"slots": 0}, {"points": -1}, {"render_mode": "human"}):
        with pytest.raises(InvalidInput, match="expected"):
            Picking(**wrong)
    with pytest.raises(InvalidInput, match="there is no scene 'heap'"):
        Picking("heap").reset(seed=0)
    with pytest.raises(InvalidInput, match="step before reset"):
        Picking().step(np.int64(0))


def test_without_gymnasium_its_extra_is_named():
    code = "import sys; sys.modules['gymnasium'] = None; import topple.planner.environment"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "environments need Gymnasium: pip install 'gymnasium>=1.0'" in done.stderr.splitlines()[-1]


@pytest.mark.slow
def test_gymnasium_takes_it():
    check_env(gymnasium.make("topple/Dishes-v0", render_mode="rgb_array").unwrapped)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["sync", "async"])
def test_it_vectorises(how):
    many = gymnasium.make_vec("topple/Dishes-v0", num_envs=2, vectorization_mode=how)
    seen, _ = many.reset(seed=1)
    assert seen["graph"].shape == (2, SLOTS, SLOTS)
    seen, rewards, *_ = many.step(np.array([SLOTS - 1, SLOTS - 1]))
    assert rewards.tolist() == [-EFFORT, -EFFORT]
    many.close()


@pytest.mark.slow
def test_cameras_see_less_than_there_is():
    made = Picking("dishes", cameras=1)
    seen, info = made.reset(seed=3, options={"scene": DISHES})
    slot = {name: k for k, name in enumerate(info["names"])}
    assert made.observation_space.contains(seen)
    assert seen["graph"][slot["spoon_1"], slot["plate"]] > 0
    made.close()


@pytest.mark.slow
def test_a_lemon_finds_room_in_the_bowl_once_others_are_out_of_it():
    made = gymnasium.make("topple/Lemon-v0")
    seen, info = made.reset(seed=0, options={"scene": 8})
    slot = {name: k for k, name in enumerate(info["names"])}
    assert not seen["action_mask"][slot["bowl"]]
    _, reward, ended, _, info = made.step(slot["lemon"])
    assert not info["reached"] and not ended and reward == -EFFORT  # it rolls off what is in there
    for name in sorted(set(slot) - {"bowl", "lemon"}):
        made.step(slot[name])
    _, reward, ended, _, info = made.step(slot["lemon"])
    assert info["reached"] and ended and reward == pytest.approx(1 - EFFORT)
    made.close()


def test_gymnasium_makes_one_without_anything_imported_before():
    code = (
        "import gymnasium\n"
        "made = gymnasium.make('topple.planner.environment:topple/Pile-v0')\n"
        "print(made.spec.id, made.unwrapped.action_space)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "topple/Pile-v0 Discrete(12)\n"


def test_plain_names_do_where_both_are_imported():
    for code in (
        "import gymnasium, topple; print(gymnasium.make('topple/Pile-v0').spec.id)",
        "import gymnasium; print(gymnasium.make('topple:topple/Pile-v0').spec.id)",
        "import gymnasium, topple.planner.environment; print(gymnasium.make('topple/Pile-v0').spec.id)",
    ):
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert done.stdout == "topple/Pile-v0\n"
    loads = "import sys, topple; print('gymnasium' in sys.modules or 'numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", loads], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"  # who does not learn does not wait


def test_a_goal_is_judged_by_poses_and_forces_and_not_by_relations(monkeypatch):
    made = Picking("tower", slots=4)
    _, info = made.reset(seed=0)
    slot = {name: np.int64(k) for k, name in enumerate(info["names"])}
    made.step(slot["green"])  # onto blue
    stage = made._stage
    assert stage is not None and not made._is_reached(stage)  # red is not on it yet
    world = stage.world
    for name, low in (("green", "blue"), ("red", "green")):
        pose = world.pose(low).copy()
        pose[2, 3] += float(np.ptp(np.concatenate(world.parts(low))[:, 2]))
        world.place(name, pose)
    world.settle(1.0)
    monkeypatch.setattr("topple.planner.decide.goal.Goal.unmet", lambda *_: ("whatever relations say",))
    assert made._is_reached(stage)
    made.close()
