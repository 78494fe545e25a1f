"""Asks one version of topple, in a process of its own: `python asked.py FOLDER`, a task a line on stdin.

Imports nothing of topple but the names that every version has: `relate`, `order`, `DepthImage`, `Scene`,
`Situation`. What a scene is given with is jittered here, alike for all versions.
"""

import json
import sys
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

FAR = np.array([1000.0, -1000.0, 0.0])  # [m] a kilometre off, and more
LEFT = 0.33  # [m] of the table to each side that a turn leaves: what stands on it is nearer
FINE = 2e-4  # [m] a fifth of a depth camera's step


def jittered(arrays: dict[str, Any], variant: str) -> dict[str, Any]:
    """Change what must not change an answer.

    Args:
        arrays: As `topple.benchmarks.truth.views.seen` gives them.
        variant: "" for none, or what and how: "noise 1" (seed), "half", "offset", "turn 22.5" (degrees: the
            scene about up, and the table's outline not: what hangs on a grid along either turns against it).

    Returns:
        The arrays, jittered.
    """
    what, _, given = variant.partition(" ")
    if not what:
        return arrays
    found, rng = dict(arrays), np.random.default_rng(int(float(given or 0)))
    turn, shift = np.eye(3), FAR * (what == "offset")
    if what == "turn":
        angle = np.radians(float(given))
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    for key, value in arrays.items():
        kind = key.partition("_")[0]
        if kind == "cloud":
            points = value[rng.random(len(value)) < 0.5] if what == "half" else value
            points = points + (rng.normal(0, FINE, points.shape) if what == "noise" else 0.0)
            found[key] = points @ turn.T + shift
        elif kind == "pose":
            moved = value.copy()
            moved[:3] = turn @ value[:3]
            moved[:3, 3] += shift
            found[key] = moved
        elif kind == "depth" and what in ("noise", "half"):
            kept = value > 0 if what == "noise" else (value > 0) & (rng.random(value.shape) < 0.5)
            noise = rng.normal(0, FINE, value.shape) if what == "noise" else 0.0
            found[key] = np.where(kept, value + noise, 0.0)
    return _with_table_cut(found) if what == "turn" else found


def _with_table_cut(arrays: dict[str, Any]) -> dict[str, Any]:
    """The table, the last of the names, cut to a square along x and y."""
    found, last = dict(arrays), len(arrays["names"])
    if (key := f"cloud_{last - 1}") in arrays:
        found[key] = arrays[key][(np.abs(arrays[key][:, :2]) < LEFT).all(axis=1)]
    for key in (key for key in arrays if key.startswith("depth_")):
        depth, pose = arrays[key], arrays[key.replace("depth", "pose")]
        rows, columns = np.nonzero((arrays[key.replace("depth", "label")] == last) & (depth > 0))
        rays = np.column_stack([columns, rows, np.ones(len(rows))]) @ np.linalg.inv(arrays["K"]).T
        points = (rays * depth[rows, columns][:, None]) @ pose[:3, :3].T + pose[:3, 3]
        beyond = (np.abs(points[:, :2]) >= LEFT).any(axis=1)
        found[key] = depth.copy()
        found[key][rows[beyond], columns[beyond]] = 0.0
    return found


def scene_of(arrays: Mapping[str, Any]) -> Any:
    """The scene: of clouds, of images, or of a file, whatever the arrays hold."""
    from topple.topology import DepthImage, Scene, load_scene

    fixed = [str(name) for name in arrays.get("fixed", ())]
    if "path" in arrays:
        return load_scene(str(arrays["path"]), fixed=fixed)
    up = arrays.get("up", (0, 0, 1))
    names = {k + 1: str(name) for k, name in enumerate(arrays["names"])}
    if "cloud_0" in arrays:
        clouds = {name: arrays[f"cloud_{k - 1}"] for k, name in names.items()}
        return Scene(clouds, fixed=fixed, up=up, viewpoints=arrays.get("viewpoints"))
    images = [
        DepthImage(arrays[f"depth_{k}"].astype(float), arrays["K"], arrays[f"label_{k}"].astype(int),
                   arrays[f"pose_{k}"], names)
        for k in range(sum(key.startswith("depth_") for key in arrays))
    ]  # fmt: skip
    shown = {name for image in images for name in image.clouds()}
    return Scene.from_images(images, fixed=[name for name in fixed if name in shown], up=up)


def answer(task: Mapping[str, Any]) -> dict[str, Any]:
    """What topple says of a scene.

    Args:
        task: `arrays`: a file; `variant`: see `jittered`; `targets`: names to free one by one; `fixed`: where
            the file does not say; `seed`: of the order.

    Returns:
        Assumptions, relations that are not disjoint, dependencies, order, groups, risks, what goes first for
        each target; or `refused`, with the sentence.
    """
    import topple
    from topple.topology import Situation

    if task.get("load"):
        arrays: dict[str, Any] = {"path": task["arrays"], "fixed": task["fixed"]}
    else:
        with np.load(task["arrays"], allow_pickle=False) as held:
            arrays = jittered({key: held[key] for key in held.files}, task["variant"])
    found: dict[str, Any] = {}
    try:
        scene = scene_of(arrays)
        found |= {"names": list(scene.names), "objects": list(scene.movable)}
        found["assumptions"] = list(scene.assumptions)
        told = topple.relate(scene).to_json()["relations"]
        found["relations"] = [[p["a"], p["b"], p["relation"]] for p in told if p["relation"] != "disjoint"]
        situation = Situation(scene)
        order = topple.order(situation, seed=task["seed"]).to_json()
        keys = ("first", "then", "reason", "confidence")
        found["dependencies"] = [[edge[key] for key in keys] for edge in order["dependencies"]]
        found |= {key: order[key] for key in ("order", "groups", "risk")}
        found["first"] = {
            target: _first(situation, target, task["seed"])
            for target in task["targets"]
            if target in scene.movable
        }
    except topple.ToppleError as error:
        found["refused"] = f"{type(error).__name__}: {error}"
    return found


def _first(situation: Any, target: str, seed: int) -> list[Any] | None:
    """What goes first for a target, the group it is of, and how many go; None where that is refused."""
    import topple

    try:
        told = topple.order(situation, [target], seed=seed).to_json()
    except topple.ToppleError:
        return None
    if not told["order"]:
        return None
    name = told["order"][0]
    return [name, next((group for group in told["groups"] if name in group), []), len(told["order"])]


def main() -> None:
    """Answer until the input ends; anything unexpected is an answer too."""
    import topple

    if not Path(topple.__file__ or "").is_relative_to(sys.argv[1]):
        raise SystemExit(f"{topple.__file__} is not the version below {sys.argv[1]} that was to be asked")
    print(json.dumps({"ready": topple.__file__}), flush=True)  # noqa: T201
    warnings.simplefilter("ignore")
    for line in sys.stdin:
        task = json.loads(line)
        try:
            found = answer(task)
        except Exception as error:  # a fault of the version that is asked is a figure of it
            found = {"refused": f"{type(error).__name__}: {error}", "fault": True}
        print(json.dumps(found), flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
