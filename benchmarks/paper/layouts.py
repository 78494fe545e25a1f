"""What fills the world of each scene."""

from collections.abc import Mapping
from types import MappingProxyType

from topple.benchmarks.paper.rgbd_layouts import LAYOUTS as OF_BOXES
from topple.benchmarks.paper.stage import Layout
from topple.benchmarks.paper.ycb_layouts import LAYOUTS as OF_YCB

LAYOUTS: Mapping[int, Layout] = MappingProxyType({**OF_BOXES, **OF_YCB})
