"""Broken files of every kind: a reader reads what it is given rightly, or refuses it in a line."""

from topple.benchmarks.fuzz.counting import ReaderCount, fuzz
from topple.benchmarks.fuzz.reader import Reader
from topple.benchmarks.fuzz.readers import READERS

__all__ = ["READERS", "Reader", "ReaderCount", "fuzz"]
