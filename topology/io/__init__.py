"""Every input format becomes a Scene: `load_scene` tells them apart by what is in the file."""

from topple.topology.io.load import load_scene
from topple.topology.io.sequence import load_sequence

__all__ = ["load_scene", "load_sequence"]
