"""The section on the six methods of the benchmark's paper, from records of those that were run."""

from .pictures import PICTURES
from .section import section

__all__ = ["PICTURES", "section"]
