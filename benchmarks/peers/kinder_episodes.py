"""Write the starts of KinDER's episodes, and play plans in them; run by the Python that has it.

    python kinder_episodes.py FOLDER

`kindergarden` (MIT) has the environments. Of `asked.json`, a name and seeds, it makes `starts.json`: the arm
and for each seed what is there, convex parts in the world. Of `plans.json`, the states and hands of seeds, it
makes `played.json`: what came of each.
"""

import json
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

STEP = 0.19
"""Of the 0.2 rad that an action may turn a joint by."""

REACHED = 2e-3
"""[rad] by which rounding keeps a joint from where it was sent; a step that meets something stays behind."""


def starts(folder: Path) -> dict[str, Any]:
    """Arm, and objects of each seed."""
    asked: dict[str, Any] = json.loads((folder / "asked.json").read_text(encoding="utf-8"))
    env, inner = made(asked["environment"])
    arm = inner.robot.arm
    episodes: list[dict[str, Any]] = []
    for seed in asked["seeds"]:
        env.reset(seed=seed)
        names = sorted(inner._get_movable_object_names())
        others = sorted(inner._get_surface_object_names())
        parts = {name: parts_of(inner, name) for name in [*names, *others]}
        episodes.append({"seed": seed, "parts": parts, "fixed": others})
    pose = arm.get_base_pose()
    start = list(inner.config.initial_joints)
    base = [*pose.position, *pose.orientation]
    return {"urdf": str(arm.urdf_path), "base": base, "start": start, "episodes": episodes}


def made(name: str) -> tuple[Any, Any]:
    """An environment, and the one in it that knows its objects; without the picture behind."""
    kinder: Any = import_module("kinder")
    kinder.register_all_environments()
    env = kinder.make(f"kinder/{name}-v0", realistic_bg=False)
    return env, env.unwrapped._object_centric_env


def parts_of(inner: Any, name: str) -> list[Any]:
    """The convex parts (V, 3) of an object, as its collision shapes have them [m]."""
    engine: Any = import_module("pybullet")
    turned: Any = import_module("scipy.spatial.transform").Rotation.from_quat
    body, client = inner._object_name_to_pybullet_id(name), inner.physics_client_id
    found: list[Any] = []
    for link in range(-1, engine.getNumJoints(body, physicsClientId=client)):
        for shape in engine.getCollisionShapeData(body, link, physicsClientId=client):
            corners = corners_of(inner, name, shape)
            for place, turn in ((shape[5], shape[6]), _frame(engine, body, link, client)):
                corners = turned(turn).apply(corners) + place
            found.append(corners.tolist())
    return found


def corners_of(inner: Any, name: str, shape: Any) -> Any:
    """(V, 3) corners of a box, or of the one other shape there is: a prism."""
    if shape[2] == import_module("pybullet").GEOM_BOX:
        return np.array(np.meshgrid(*[(-side / 2, side / 2) for side in shape[3]])).reshape(3, 8).T
    return inner._triangle_prism_local_geometry(*np.roll(inner._get_triangle_features(name), 1))[0]


def _frame(engine: Any, body: int, link: int, client: int) -> Any:
    if link < 0:
        return engine.getBasePositionAndOrientation(body, physicsClientId=client)
    return engine.getLinkState(body, link, computeForwardKinematics=True, physicsClientId=client)[4:6]


def played(folder: Path) -> list[dict[str, Any]]:
    """What came of each plan."""
    document: dict[str, Any] = json.loads((folder / "plans.json").read_text(encoding="utf-8"))
    env, inner = made(document["environment"])
    return [_episode(env, inner, plan) for plan in document["plans"]]


def _episode(env: Any, inner: Any, plan: dict[str, Any]) -> dict[str, Any]:
    env.reset(seed=plan["seed"])
    begun, steps, reached, why = time.process_time(), 0, False, ""
    for k, (kind, hand, states) in enumerate(plan["pieces"]):
        for state in states:
            while not reached and not why:
                state_now = np.array(inner.robot.arm.get_joint_positions()[:7])
                left = (np.array(state) - state_now + np.pi) % (2 * np.pi) - np.pi
                if np.abs(left).max() < REACHED:
                    break
                left *= min(1.0, STEP / np.abs(left).max())
                reached, steps = _step(env, left, 0.0), steps + 1
                gone = np.array(inner.robot.arm.get_joint_positions()[:7]) - state_now
                if np.abs((gone - left + np.pi) % (2 * np.pi) - np.pi).max() > REACHED:
                    why = f"piece {k}, {kind}: something is in the way"
        if hand and not reached and not why:
            reached, steps = _step(env, np.zeros(7), hand), steps + 1
            if (inner._grasped_object is not None) != (hand < 0):
                why = f"piece {k}, {kind}: {inner._grasped_object} in the hand"
    seconds = time.process_time() - begun
    return {"seed": plan["seed"], "reached": reached, "steps": steps, "why": why, "seconds": seconds}


def _step(env: Any, turns: Any, hand: float) -> bool:
    action = np.concatenate([np.zeros(3), turns, [hand]]).astype(np.float32)
    return bool(env.step(action)[2])


if __name__ == "__main__":
    where = Path(sys.argv[1])
    if (where / "plans.json").exists():
        (where / "played.json").write_text(json.dumps(played(where)), encoding="utf-8")
    else:
        (where / "starts.json").write_text(json.dumps(starts(where)), encoding="utf-8")
