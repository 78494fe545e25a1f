"""`topple rank`: which grasps of another pipeline may be done now, which later, and what bars the others."""

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from topple.planner.cli.arguments import COMMON, add, add_robot, add_scenes
from topple.planner.cli.console import complain, print_json, print_table, print_text
from topple.planner.cli.main import DONE, WRONG_USE
from topple.planner.cli.options import orderer_of, read_scene, rule_of, scene_paths
from topple.planner.cli.progress import Progress
from topple.planner.cli.robot_options import arm_of, base_of
from topple.planner.cli.tables import print_assumptions
from topple.topology.base.errors import InvalidInput

if TYPE_CHECKING:
    from topple.planner.decide.dependency import DependencyGraph
    from topple.planner.grasp.foreign import ForeignGrasps
    from topple.planner.grasp.rank import RankedGrasp
    from topple.robots.arm.arm import Arm
    from topple.topology.scene.scene import Scene

PIPE = "-"
"""Names standard input."""
_KINDS = {b"\x93NUMPY": ".npy", b"PK": ".npz"}  # what files begin with, and what their names end in


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    kinds = "GraspNet .npy, Contact-GraspNet .npz, isaac .yaml, 4x4 poses, or - for what is piped in"
    add_scenes(parser, "SCENE GRASPS", f"a scene, and grasps in its frame: {kinds}; more such pairs")
    add_robot(parser)
    add(parser, "--target", "--rule", "--orderer", "--masks-as-they-are", *COMMON)


def execute(args: argparse.Namespace) -> int:
    """Rank the grasps of each scene and print them, best first; 2 where one of several cannot be read."""
    paths = scene_paths(args)
    if len(paths) % 2:
        args.parser.error(f"a scene and a file of grasps expected, given {' '.join(paths)}")
    pairs = list(zip(paths[::2], paths[1::2], strict=True))
    if [grasps for _, grasps in pairs].count(PIPE) > 1:
        args.parser.error("grasps of standard input can be read once: give one -")
    for asked in (orderer_of, rule_of):
        asked(args)  # refused before anything is read
    arm, code = arm_of(args), DONE
    with Progress("rank") as progress:
        for scene, grasps in pairs:
            try:
                _rank(args, scene, grasps, arm, progress)
            except InvalidInput as error:  # of many, one that fails keeps none of the others from its turn
                if len(pairs) == 1:
                    raise
                complain(f"{scene}, {grasps}: {error}")
                code = WRONG_USE
    return code


def _rank(args: argparse.Namespace, path: str, file: str, arm: "Arm", progress: Progress) -> None:
    """Rank the grasps of one scene and print them."""
    from topple.planner.grasp.rank import camera_frame, rank_grasps
    from topple.planner.planning.order import check_masks, check_targets

    progress(f"reading {path}")
    scene = read_scene(args, path)
    wanted = check_targets(scene, args.target) if args.target else ()
    scene = check_masks(scene, wanted)
    grasps = _read(file)
    progress(f"{path}: ranking {len(grasps)} grasps")
    base = base_of(args, scene)
    graph, frame = _graph(args, scene), camera_frame(scene, grasps)
    ranked = rank_grasps(scene, grasps, arm, pose_source_to_world=frame, pose_base_to_world=base, graph=graph)
    progress.clear()
    ranked = [entry for entry in ranked if not wanted or entry.grasp.object in wanted]
    reach = base is not None or scene.robot_base is not None
    if args.json:
        document = _document((path, file), arm.name, reach, ranked)
        print_json({**document, "grasps_in": "scene" if frame is None else "camera"})
        return
    _print((path, file), grasps.source, args.said(ranked))
    if not reach:
        print_text("Reach was not asked: give --base, or a scene with robot_base.")
    if frame is not None:
        print_assumptions(["the grasps are in the camera's frame: they are taken by its pose in the scene"])
    print_assumptions(list(scene.assumptions))


def _graph(args: argparse.Namespace, scene: "Scene") -> "DependencyGraph | None":
    """Find the dependencies by the named rule and orderer; None where none was named."""
    orderer, relating = orderer_of(args), rule_of(args)
    if orderer is None and relating is None:
        return None
    from topple.planner.planning.order import ordered
    from topple.planner.planning.step import order_by

    relations = None if relating is None else relating(scene)
    return order_by(orderer or ordered, scene, None, relations, args.seed).graph


def _read(file: str) -> "ForeignGrasps":
    """The grasps of a file, or of what is piped in."""
    from topple.planner.grasp.foreign import read_grasps

    if file != PIPE:
        return read_grasps(file)
    content = sys.stdin.buffer.read()
    kind = next((end for start, end in _KINDS.items() if content.startswith(start)), ".yaml")
    with tempfile.TemporaryDirectory(prefix="topple-") as folder:
        place = Path(folder) / f"stdin{kind}"
        place.write_bytes(content)
        return read_grasps(place)


def _document(
    paths: Sequence[str], robot: str, reach: bool, ranked: "Sequence[RankedGrasp]"
) -> dict[str, Any]:
    """The `topple.rank` document; what is not known is null."""
    return {
        "format": "topple.rank",
        "format_version": 1,
        "scene": paths[0],
        "file": paths[1],
        "robot": robot,
        "reach_asked": reach,
        "grasps": [
            {
                "rank": rank,
                "index": entry.index,
                "object": entry.grasp.object or None,
                "pose_tool_to_world": entry.grasp.pose_tool_to_world.tolist(),
                "width": entry.grasp.opening or None,
                "score": entry.grasp.score,
                "feasible": entry.feasible,
                "why": entry.why,
                "unseen": entry.grasp.unseen,
                "before": list(entry.before),
            }
            for rank, entry in enumerate(ranked, start=1)
        ],
    }


def _print(paths: Sequence[str], source: str, ranked: "Sequence[RankedGrasp]") -> None:
    free = [entry for entry in ranked if entry.feasible]
    objects = Counter(entry.grasp.object for entry in free)
    which = ", ".join(f"{count} of {name}" for name, count in objects.items())
    print_text(f"{paths[1]} ({source}) in {paths[0]}: {len(free)} of {len(ranked)} grasps can be done now")
    if which:
        print_text(f"They hold: {which}.")
    if ranked:
        rows = [_row(rank, entry) for rank, entry in enumerate(ranked, start=1)]
        print_table(("", "grasp", "object", "score", "width mm", ""), rows, right=(0, 1, 3, 4))


def _row(rank: int, entry: "RankedGrasp") -> tuple[str, ...]:
    width = f"{1e3 * entry.grasp.opening:.0f}" if entry.grasp.opening else ""
    name = entry.grasp.object
    return (str(rank), str(entry.index), name, f"{entry.grasp.score:.3g}", width, entry.why or "now")
