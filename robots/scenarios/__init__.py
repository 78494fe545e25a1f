"""Built-in scenes: settled worlds with cameras, a robot's place and a task, each made from a seed."""

from topple.robots.scenarios.dishes import dishes
from topple.robots.scenarios.scenario import Scenario

__all__ = ["Scenario", "dishes"]
