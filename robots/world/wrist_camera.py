"""A depth camera on the hand, which the arm carries to where it shall look from."""

from dataclasses import dataclass, field, replace

import numpy as np

from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.camera import Camera
from topple.topology.base.arrays import FloatArray
from topple.topology.views.image import DepthImage


def _beside_the_fingers() -> FloatArray:
    """8 cm aside of the tool and 10 cm behind its tip, looking along it, as such cameras are mounted."""
    pose = np.eye(4)
    pose[:3, 3] = 0.08, 0.0, -0.1
    return pose


@dataclass
class WristCamera:
    """A camera fixed beside the first tool of a simulated arm; it has no body that could meet anything.

    Attributes:
        robot: The arm that carries it.
        camera: Its optics and faults; where it stands is the arm's affair.
        rng: Of its noise.
        pose_camera_to_tool: (4, 4) how it is mounted.
    """

    robot: ActingArm
    camera: Camera
    rng: np.random.Generator
    pose_camera_to_tool: FloatArray = field(default_factory=_beside_the_fingers)

    @property
    def tool(self) -> str:
        """The tool that it is mounted beside."""
        return next(iter(self.robot.arm.tools))

    def picture(self) -> DepthImage:
        """Take a picture from where the arm has the camera; its pose is what the joints say."""
        robot, tool = self.robot, self.tool
        true = robot.tool_pose(tool) @ self.pose_camera_to_tool
        said = robot.pose_base_to_world @ robot.arm.tool_pose(robot.q_target, tool)[0]
        image = replace(self.camera, pose_camera_to_world=true).look(robot.world, self.rng)
        return replace(image, pose_camera_to_world=said @ self.pose_camera_to_tool)
