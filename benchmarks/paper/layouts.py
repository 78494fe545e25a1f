"""What fills the world of each scene."""

from collections.abc import Mapping
from types import MappingProxyType

from topple.benchmarks.paper import rgbd_layouts, ycb_layouts
from topple.benchmarks.paper.stage import Layout

LAYOUTS: Mapping[int, Layout] = MappingProxyType(
    {
        number: getattr(rgbd_layouts if number < 8 else ycb_layouts, f"scene_{number}")
        for number in range(1, 15)
    }
)
