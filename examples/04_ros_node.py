"""A ROS 2 node: for every labelled PointCloud2, what to take next and why, as JSON on the topic `order`.

python examples/04_ros_node.py --ros-args -r points:=/camera/points -p fixed:=[1]
"""

import json
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

import topple
from topple.planner.report.figure import show_picture
from topple.robots.shapes import box


def answer(cloud: Any, fixed: list[int]) -> str:
    """The order of a cloud's objects as JSON, z up, or in one line why there is none."""
    try:
        scene = topple.topology.scene_from_points(cloud, fixed=map(str, fixed), up=(0, 0, 1))
        return json.dumps(topple.order(scene).to_json())
    except topple.ToppleError as error:
        return json.dumps({"error": str(error)})


def spin() -> None:
    """Answer until Ctrl-C; of the clouds that come meanwhile only the newest waits."""
    rclpy, msgs, std = map(import_module, ("rclpy", "sensor_msgs.msg", "std_msgs.msg"))
    rclpy.init()
    node = rclpy.create_node("topple")
    fixed = list(node.declare_parameter("fixed", [1]).value)  # labels
    say = node.create_publisher(std.String, "order", 1).publish
    node.create_subscription(msgs.PointCloud2, "points", lambda c: say(std.String(data=answer(c, fixed))), 1)
    rclpy.spin(node)


def made_up() -> Any:
    """A table (1), a book (2) and one on it (3), as a node would receive them."""
    from rosbags.typesys import Stores, get_typestore

    slabs = {(0.8, 0.8, 0.02): -0.01, (0.2, 0.15, 0.03): 0.015, (0.16, 0.12, 0.03): 0.045}  # size: height [m]
    store, rng = get_typestore(Stores.ROS2_JAZZY), np.random.default_rng(0)
    make = {name.rpartition("/")[2]: each for name, each in store.types.items()}
    seen = [box("slab", size).surface(3000, rng) + np.array([0, 0, z]) for size, z in slabs.items()]
    rows = np.column_stack([np.concatenate(seen), np.repeat([1, 2, 3], 3000)]).astype("<f4")
    fields = [make["PointField"](name, 4 * k, 7, 1) for k, name in enumerate(("x", "y", "z", "label"))]
    about = (1, len(rows), fields, False, 16, rows.nbytes, rows.view("u1").ravel(), True)
    cloud = make["PointCloud2"](make["Header"](make["Time"](0, 0), "world"), *about)
    return store.deserialize_cdr(store.serialize_cdr(cloud, cloud.__msgtype__), cloud.__msgtype__)


if __name__ == "__main__":
    try:
        spin()
    except ModuleNotFoundError:  # no ROS here: one cloud that went through its serialisation
        print(answer(cloud := made_up(), [1]))
        scene = topple.topology.scene_from_points(cloud, fixed=["1"], up=(0, 0, 1))
        Path("ros_node.png").write_bytes(show_picture(scene, topple.relate(scene), topple.order(scene)))
