"""A second look before a doubtful step: the arm carries a camera to where most of what is hidden shows."""

from typing import Protocol, runtime_checkable

import numpy as np

from topple.planner.decide.arrange import Order
from topple.planner.execution.execute import go_home
from topple.planner.execution.tolerances import DOUBTFUL, SPEED, STILL, TURNS, VIEWS_TRIED
from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import MotionFailure, plan_motion
from topple.planner.motion.trajectory import retime
from topple.planner.planning.next_view import View, next_views
from topple.planner.transfer.tolerances import MARGIN
from topple.robots.driver import Driver
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.situation.situation import Situation
from topple.topology.views.image import DepthImage


@runtime_checkable
class HandCamera(Protocol):
    """A depth camera that an arm carries."""

    @property
    def pose_camera_to_tool(self) -> FloatArray:
        """(4, 4) how it is mounted."""
        ...

    @property
    def tool(self) -> str:
        """The tool that it is mounted beside."""
        ...

    def picture(self) -> DepthImage:
        """Take a picture from where the arm has it."""
        ...


def doubtful(order: Order, name: str) -> bool:
    """Whether taking an object now may well move something: then a second look pays.

    Args:
        order: The order that the step was chosen from.
        name: The object.
    """
    return order.risk.get(name, 0.0) > DOUBTFUL


def second_look(
    camera: HandCamera, robot: Driver, situation: Situation, order: Order, seed: int
) -> tuple[DepthImage, View] | None:
    """Look from the best place that the arm gets the camera to, and come back.

    Args:
        camera: What the arm carries.
        robot: The arm, holding nothing.
        situation: What is known so far.
        order: The order in doubt.
        seed: Of the searches.

    Returns:
        The picture and the view; None where no view is worth it, or the arm gets to none of the best.
    """
    views = next_views(situation, found=order)[:VIEWS_TRIED]
    if not views:
        return None
    arm, base = robot.arm, robot.pose_base_to_world
    checker = Checker(arm, base, situation.solids, tool_state=robot.tool_state, margin=MARGIN)
    for view in views:
        goals = _states(camera, robot, view)
        clear = [q for q in goals if not checker.contacts(q)]
        if not clear:
            continue
        found = plan_motion(checker, robot.q_target, np.stack(clear), seed=seed)
        if isinstance(found, MotionFailure):
            continue
        robot.follow(retime(arm, found.path, SPEED))
        robot.wait(STILL)
        image = camera.picture()
        go_home(robot, situation.solids, seed)
        return image, view
    return None


def _states(camera: HandCamera, robot: Driver, view: View) -> list[FloatArray]:
    """Joint values (n,) that bring the camera to a view, however it is turned about its line of sight."""
    to_base = inverse(robot.pose_base_to_world)
    targets: list[FloatArray] = []
    for turn in np.arange(TURNS) * 2.0 * np.pi / TURNS:
        rolled = np.eye(4)
        rolled[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        targets.append(to_base @ view.pose_camera_to_scene @ rolled @ inverse(camera.pose_camera_to_tool))
    solved = robot.arm.inverse(np.stack(targets), camera.tool, seeds=8, near=robot.q_target)
    return [q for some in solved for q in some[:1]]
