"""Parts of a plan's document that the sabotages change."""

from collections.abc import Callable
from typing import Any

import numpy as np

Document = dict[str, Any]
Sabotage = Callable[[Document], bool | None]
"""Changes a document; False where there is nothing to change in it."""


def segments_of(document: Document, kind: str) -> list[Document]:
    return [part for step in document["steps"] for part in step["segments"] if part["kind"] == kind]


def drop_segments(step: Document, *kinds: str) -> None:
    step["segments"] = [part for part in step["segments"] if part["kind"] not in kinds]


def index_of(step: Document, kind: str) -> int:
    return [part["kind"] for part in step["segments"]].index(kind)


def last_step(document: Document) -> Document:
    step: Document = document["steps"][-1]
    return step


def first_step(document: Document) -> Document:
    step: Document = document["steps"][0]
    return step


def has_fingers(document: Document) -> bool:
    return any(part["tool"] == "fingers" for step in document["steps"] for part in step["segments"])


def shift(matrix: list[list[float]], axis: int, by: float) -> None:
    matrix[axis][3] += by


def turn(matrix: list[list[float]], by: float) -> None:
    about_z = np.array([[np.cos(by), -np.sin(by), 0.0], [np.sin(by), np.cos(by), 0.0], [0.0, 0.0, 1.0]])
    rotation = np.array(matrix)[:3, :3] @ about_z
    for row in range(3):
        matrix[row][:3] = rotation[row].tolist()


def backwards(motion: Document) -> Document:
    end = motion["times"][-1]
    return {
        "times": [end - time for time in reversed(motion["times"])],
        "positions": motion["positions"][::-1],
        "velocities": [[-value for value in row] for row in reversed(motion["velocities"])],
    }
