"""`topple robot`: what was understood of an arm, what it can do, and the line to use it with."""

import argparse
import shlex
from typing import TYPE_CHECKING, Any

from topple.planner.cli.arguments import COMMON, GRIPPER, OPTIONS, add
from topple.planner.cli.console import in_options, print_json, print_table, print_text
from topple.planner.cli.main import DONE, NO_SAFE_PLAN
from topple.planner.cli.progress import Progress
from topple.planner.cli.robot_options import output_of, robot_of
from topple.topology.base.files import write_whole

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    parser.add_argument("robot", metavar="ROBOT", help=OPTIONS["--robot"]["help"])
    add(parser, *GRIPPER, *COMMON, "--no-grasp")
    add(parser, "--report", more=": the arm at home, out.png")


def execute(args: argparse.Namespace) -> int:
    """Read an arm, try it, and say what was found; 1 if it has no tool, misses poses, or the grasp fails."""
    place = output_of(args, "report")
    with Progress("robot") as progress:
        progress(f"reading {args.robot}")
        arm = robot_of(args)
        from topple.planner.execution.examine import examine

        found = examine(arm, grasp=not args.no_grasp, seed=args.seed, progress=progress)
        if place is not None:
            progress("drawing")
            write_whole(place, _picture(arm))
    line = _line(args)
    if args.json:
        head: dict[str, Any] = {"format": "topple.robot", "format_version": 1, "robot": args.robot}
        print_json({**head, **found.to_json(), "command": line if found.arm.tools else None})
    else:
        _print(args.robot, found.to_json(), line, arm)
    return DONE if found.ok else NO_SAFE_PLAN


def _line(args: argparse.Namespace) -> str:
    """The command to plan with this arm."""
    words = ["--robot", args.robot]
    for option in ("gripper", "srdf", "group"):
        value = getattr(args, option)
        words += [] if value is None else [f"--{option}", value]
    return f"topple plan SCENE --target NAME {shlex.join(words)} -o plan.json"


def _print(robot: str, said: dict[str, Any], line: str, arm: "Arm") -> None:
    many = len(said["joints"])
    print_text(f"{robot}: {said['name']}, {many} joints from {said['base']}, reach {said['reach']:.2f} m")
    limits = ("lower", "upper", "velocity", "acceleration")
    rows = [(each["name"], each["kind"], *(f"{each[key]:.2f}" for key in limits)) for each in said["joints"]]
    print_table(("joint", "kind", *limits), rows, right=(2, 3, 4, 5))
    if said["still"]:
        print_text(f"Hold still: {', '.join(said['still'])}.")
    for tool in said["tools"]:
        print_text(_tool_words(tool))
    own = said["self_collision"]
    disabled = f", {own['disabled']} left out as the SRDF has it" if own["disabled"] else ""
    checked = f"({own['pairs']} pairs of links checked{disabled})"
    print_text(f"Self-collision: {100 * own['free']:.1f} % of all states are free {checked}.")
    if said["tools"]:
        asked = said["inverse"]
        share, bar = 100 * asked["solved"] / max(asked["poses"], 1), 100 * asked["bar"]
        verdict = "" if asked["ok"] else f": below {bar:.1f} %"
        print_text(f"Inverse kinematics: {share:.1f} % of {asked['poses']} reachable poses{verdict}.")
    print_text(_grasp_words(said))
    for assumption in said["assumptions"]:
        print_text(f"Assumed: {assumption}.")
    if said["tools"]:
        print_text("", f"Use it: {line}")
        return
    from topple.robots.catalog.own_arm import tool_advice

    print_text("", in_options(tool_advice(arm)))


def _tool_words(tool: dict[str, Any]) -> str:
    at = " ".join(f"{row[3]:.3f}" for row in tool["pose_tool_to_link"][:3])
    return f"Tool {tool['name']} at {at} in {tool['link']}: {tool['words']}."


def _grasp_words(said: dict[str, Any]) -> str:
    grasp = said["grasp"]
    if grasp is None:
        return f"Grasp in simulation: not tried, {said['untried']}."
    held = grasp["object"]
    if held is None:
        return f"Grasp in simulation: failed. {'; '.join(grasp['why'])}."
    x, y, z = held["place"]
    what = (
        f"a cube of {1e3 * held['side']:.0f} mm and {1e3 * held['mass']:.0f} g at {x:.2f} {y:.2f} {z:.2f} m"
    )
    if grasp["success"]:
        return f"Grasp in simulation: {what} taken, lifted and put down elsewhere."
    return f"Grasp in simulation: {what} failed. {'; '.join(grasp['why'])}."


def _picture(arm: "Arm") -> bytes:
    """An arm at home, as PNG."""
    import numpy as np

    from topple.planner.formats.pictures import picture
    from topple.robots.world.camera import Camera
    from topple.robots.world.simulated_arm import SimulatedArm
    from topple.robots.world.world import World
    from topple.topology.geometry.rigid import move_points

    placed = zip(arm.parts, arm.forward(arm.home)[0], strict=True)
    points = np.concatenate([move_points(part, pose) for parts, pose in placed for part in parts])
    low, high = points.min(axis=0), points.max(axis=0)
    eye = (low + high) / 2.0 + np.array([0.6, -1.0, 0.5]) * np.linalg.norm(high - low)
    with World() as world:
        SimulatedArm(world, arm, np.eye(4))
        camera = Camera.looking_at(tuple(eye.tolist()), tuple(((low + high) / 2.0).tolist()))
        return picture(camera.picture(world))
