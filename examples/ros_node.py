"""A ROS 2 node: for every labelled PointCloud2, what to take next and why, as JSON on the topic `order`.

python examples/ros_node.py --ros-args -r points:=/camera/points -p fixed:=[1]
"""

import json
from importlib import import_module
from typing import Any

import numpy as np

import topple
from topple.robots.shapes import box
from topple.topology import scene_from_points

RNG = np.random.default_rng(0)
SLABS = {(0.8, 0.8, 0.02): -0.01, (0.2, 0.15, 0.03): 0.015, (0.16, 0.12, 0.03): 0.045}  # size: height [m]


def answer(cloud: Any, fixed: list[int]) -> str:
    """The order of a cloud's objects as JSON, z up, or in one line why there is none."""
    try:
        scene = scene_from_points(cloud, fixed=map(str, fixed), up=(0, 0, 1))
        return json.dumps(topple.order(scene).to_json())
    except topple.ToppleError as error:
        return json.dumps({"error": str(error)})


def spin() -> None:
    """Answer until Ctrl-C; of the clouds that come meanwhile only the newest waits."""
    rclpy, sensor, std = map(import_module, ("rclpy", "sensor_msgs.msg", "std_msgs.msg"))
    rclpy.init()
    node = rclpy.create_node("topple")
    fixed = list(node.declare_parameter("fixed", [1]).value)  # labels
    out = node.create_publisher(std.String, "order", 1)
    told = "points", lambda cloud: out.publish(std.String(data=answer(cloud, fixed))), 1
    node.create_subscription(sensor.PointCloud2, *told)
    rclpy.spin(node)


def made_up() -> Any:
    """A table (1), a book (2) and one on it (3), as a node would receive them."""
    from rosbags.typesys import Stores, get_typestore

    store: Any = get_typestore(Stores.ROS2_JAZZY)
    make = {name.rpartition("/")[2]: each for name, each in store.types.items()}
    seen = [box("slab", size).surface(3000, RNG) + np.array([0, 0, z]) for size, z in SLABS.items()]
    rows = np.column_stack([np.concatenate(seen), np.repeat([1, 2, 3], 3000)]).astype("<f4")
    fields = [make["PointField"](name, 4 * k, 7, 1) for k, name in enumerate(("x", "y", "z", "label"))]
    about = (1, len(rows), fields, False, 16, rows.nbytes, rows.view("u1").ravel(), True)
    cloud = make["PointCloud2"](make["Header"](make["Time"](0, 0), "world"), *about)
    return store.deserialize_cdr(store.serialize_cdr(cloud, cloud.__msgtype__), cloud.__msgtype__)


if __name__ == "__main__":
    try:
        spin()
    except ModuleNotFoundError:  # no ROS here: one cloud that went through its serialisation
        print(answer(made_up(), [1]))
