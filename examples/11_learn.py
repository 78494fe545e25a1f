"""A small policy learns what to take next of a pile, then plays fresh piles beside the highest first.

    python examples/11_learn.py [learned.json 64 200]  # learn on 8 [64] piles, play 1 [200] more [20 minutes]
REINFORCE in numpy, on five numbers an object out of the arrays of the observation. Needs the extra `gym`.
"""

import json
import sys
from pathlib import Path

import gymnasium
import numpy as np
from PIL import Image

BATCH, RATE, FRESH = 8, 1.5, 700_000  # scenes; step of the weights; not learned on from here on


def features(seen):
    """(12, 5): height of the top [dm], is it the target, does it bar that, is it barred, near the target."""
    target, there = seen["target"].astype(bool), seen["action_mask"].astype(bool)
    top, bars = 10 * (seen["objects"][:, 2] + seen["objects"][:, 5] / 2), seen["graph"][:, target].max(axis=1)
    near = ~seen["relations"][:, target, 6].any(axis=1) & ~target
    barred = (seen["graph"] * there[:, None]).max(axis=0)
    return np.stack([top, target, bars, barred, near], axis=1, dtype=float)


def play(env, weights, scene, rng=None):
    """Play a scene: return, gradient of the log-probability (5,), takes, things disturbed, goal reached."""
    (seen, _), ended, told, gradient = env.reset(seed=scene, options={"scene": scene}), False, [], np.zeros(5)
    while not ended:
        rows = features(seen)
        share = np.where(seen["action_mask"].astype(bool), rows @ weights, -np.inf)
        share = np.exp(share - share.max()) / np.exp(share - share.max()).sum()
        action = int(share.argmax() if rng is None else rng.choice(len(share), p=share))
        gradient += rows[action] - share @ rows
        seen, reward, done, cut, info = env.step(action)
        told, ended = [*told, (reward, len(info["disturbed"]))], done or cut
    gained, disturbed = np.sum(told, axis=0).tolist()
    return gained, gradient, len(told), int(disturbed), bool(info["reached"])


episodes, fresh = map(int, sys.argv[2:] or (8, 1))
env = gymnasium.make("topple.planner.environment:topple/Pile-v0", render_mode="rgb_array")
rng, weights, returns = np.random.default_rng(0), np.zeros(5), list[float]()
for first in range(0, episodes, BATCH):
    gained, slopes = list(zip(*(play(env, weights, first + k, rng) for k in range(BATCH)), strict=True))[:2]
    ahead = np.subtract(gained, np.mean(gained)) / (np.std(gained) + 0.1)
    weights = weights + RATE * ahead @ slopes / BATCH
    returns += gained
    print(f"{first + BATCH} scenes: return {np.mean(gained):.2f}, weights {weights.round(2)}", flush=True)
document = {"weights": weights.tolist(), "returns": returns}
for name, policy in (("learned", weights), ("highest", np.array([1000.0, 0, 0, 0, 0]))):
    rows = [play(env, policy, FRESH + k) for k in range(fresh)]
    document[name] = [[total, takes, disturbed, reached] for total, _, takes, disturbed, reached in rows]
    clean = sum(reached and not disturbed for *_, disturbed, reached in rows)
    mean = np.mean([row[0] for row in rows])
    print(f"{name}: return {mean:.2f}, nothing disturbed in {clean} of {fresh}")
Image.fromarray(env.render()).save("learned.png")  # the last pile, after the highest first
Path(*sys.argv[1:2] or ["learned.json"]).write_text(json.dumps(document), encoding="utf-8")
