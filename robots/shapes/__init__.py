"""Procedural household things with real dimensions and masses: z up, resting on z = 0, centred in xy."""

from topple.robots.shapes.boxes import bar, block, box, can, tray
from topple.robots.shapes.cutlery import fork, spoon
from topple.robots.shapes.fruit import apple, ball, banana, lemon, orange, pear, plum, strawberry
from topple.robots.shapes.packages import bottle, tin
from topple.robots.shapes.tableware import bowl, cup, mug, plate

__all__ = [
    "apple", "ball", "banana", "bar", "block", "bottle", "bowl", "box", "can", "cup", "fork",
    "lemon", "mug", "orange", "pear", "plate", "plum", "spoon", "strawberry", "tin", "tray",
]  # fmt: skip
