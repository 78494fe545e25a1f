"""What fills the world of each scene."""

from collections.abc import Mapping

from topple.benchmarks.paper.rgbd_layouts import LAYOUTS as OF_BOXES
from topple.benchmarks.paper.stage import Layout
from topple.benchmarks.paper.ycb_layouts import LAYOUTS as OF_YCB
from topple.topology.base.values import FrozenDict

LAYOUTS: Mapping[int, Layout] = FrozenDict({**OF_BOXES, **OF_YCB})
