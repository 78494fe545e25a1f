"""Cluttered scenes and queries shared by the motion tests."""

from itertools import pairwise

import numpy as np

from topple.planner.motion.collision import Checker
from topple.robots.arm.arm import Arm


def box(centre: tuple[float, float, float], size: tuple[float, float, float], yaw: float = 0.0) -> np.ndarray:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.array(size) / 2
    c, s = np.cos(yaw), np.sin(yaw)
    return corners @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T + np.array(centre)


def top_down(x: float, y: float, z: float, yaw: float = 0.0) -> np.ndarray:
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    c, s = np.cos(yaw), np.sin(yaw)
    pose[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ pose[:3, :3]
    pose[:3, 3] = x, y, z
    return pose


def clutter(seed: int, count: int = 8) -> dict[str, list[np.ndarray]]:
    """A table, boxes and round hulls on it."""
    rng = np.random.default_rng(seed)
    scene = {"table": [box((0.5, 0.0, -0.03), (1.2, 1.6, 0.04))]}
    for k in range(count):
        size = rng.uniform(0.04, 0.2, 3)
        place = (rng.uniform(0.3, 0.75), rng.uniform(-0.6, 0.6), size[2] / 2)
        if k % 2:
            ball = rng.normal(size=(60, 3))
            ball = ball / np.linalg.norm(ball, axis=1, keepdims=True) * size[0] / 2
            scene[f"ball {k}"] = [ball + place]
        else:
            scene[f"box {k}"] = [box(place, tuple(size), rng.uniform(0, 3))]
    return scene


def walled(arm: Arm, seed: int) -> tuple[Checker, np.ndarray, np.ndarray]:
    """A checker with a wall between a free start and free goals: the direct way is barred."""
    rng = np.random.default_rng(seed)
    scene = clutter(seed, 4) | {"wall": [box((0.45, 0.0, 0.25), (0.5, 0.04, 0.5))]}
    checker = Checker(arm, np.eye(4), scene)

    def side(sign: float) -> np.ndarray:
        while True:
            place = top_down(
                rng.uniform(0.35, 0.6),
                sign * rng.uniform(0.2, 0.4),
                rng.uniform(0.05, 0.2),
                rng.uniform(-1, 1),
            )
            states = arm.inverse(place, seeds=32)[0]
            states = states[checker.free(states)] if len(states) else states
            if len(states):
                return states

    return checker, side(1.0)[0], side(-1.0)[:6]


def densely(path: np.ndarray, step: float = 0.002) -> np.ndarray:
    """States on a path at most `step` rad apart."""
    pieces = [path[:1]]
    for a, b in pairwise(path):
        count = max(int(np.ceil(np.abs(b - a).max() / step)), 1)
        pieces.append(a + np.arange(1, count + 1)[:, None] / count * (b - a))
    return np.concatenate(pieces)
