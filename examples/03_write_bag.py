"""What a camera of the built-in dishes scene sees, as a recording of ROS 2 (extra `ros`) in a folder."""

import sys

import numpy as np
from PIL import Image
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from topple.robots import scenario
from topple.topology import DepthImage

STORE = get_typestore(Stores.ROS2_JAZZY)
MSG = {name.replace("/msg/", "/"): kind for name, kind in STORE.types.items()}
ROI, INFO = MSG["sensor_msgs/RegionOfInterest"](0, 0, 0, 0, False), MSG["sensor_msgs/CameraInfo"]


def write_bag(path: str, seen: list[DepthImage], base: np.ndarray, storage=StoragePlugin.MCAP) -> None:
    """Write one frame a second, all from the place of the first."""
    tree = [_transform("panda_link0", base), _transform("camera_optical", seen[0].pose_camera_to_world)]
    with Writer(path, version=9, storage_plugin=storage) as bag:
        _send(bag, 0, "/tf_static", MSG["tf2_msgs/TFMessage"](tree))
        for at, look in enumerate(seen, start=1):
            head, (height, width) = _header(at, "camera_optical"), look.depth.shape
            about = (np.zeros(5), look.K.ravel(), np.eye(3).ravel(), np.eye(3, 4).ravel(), 0, 0)
            _send(bag, at, "/camera/depth/camera_info", INFO(head, height, width, "plumb_bob", *about, ROI))
            _send(bag, at, "/camera/depth/image_rect", _image(head, 1e3 * look.depth, "16UC1", "<u2"))
            _send(bag, at, "/labels", _image(head, look.label, "mono8", "u1"))


def _header(seconds: int, frame: str):
    return MSG["std_msgs/Header"](MSG["builtin_interfaces/Time"](seconds, 0), frame)


def _image(head, pixels: np.ndarray, encoding: str, kind: str):
    rows = np.round(pixels).astype(kind)
    return MSG["sensor_msgs/Image"](head, *rows.shape, encoding, 0, rows.strides[0], rows.view("u1").ravel())


def _transform(child: str, pose: np.ndarray):
    turn = MSG["geometry_msgs/Quaternion"](*Rotation.from_matrix(pose[:3, :3]).as_quat())
    placed = MSG["geometry_msgs/Transform"](MSG["geometry_msgs/Vector3"](*pose[:3, 3]), turn)
    return MSG["geometry_msgs/TransformStamped"](_header(0, "world"), child, placed)


def _send(bag: Writer, seconds: int, topic: str, message) -> None:
    kind, known = message.__msgtype__, {each.topic: each for each in bag.connections}
    sent = known.get(topic) or bag.add_connection(topic, kind, typestore=STORE)
    bag.write(sent, seconds * 10**9, STORE.serialize_cdr(message, kind))


if __name__ == "__main__":
    path, rng = sys.argv[1] if len(sys.argv) > 1 else "run", np.random.default_rng(0)
    with scenario("dishes") as stage:
        seen = [stage.cameras[0].look(stage.world, rng) for _ in range(3)]
        write_bag(path, seen, stage.pose_base_to_world)
        Image.fromarray(seen[0].rgb).save(f"{path}.png")
        print(f"{path}: labels", *(f"{number + 1} {name}" for name, number in stage.world.ids.items()))
