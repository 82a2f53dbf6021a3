"""Section and page on the six methods of the benchmark's paper, from records of those that were run."""

from .pictures import PICTURES
from .section import page, run, section

__all__ = ["PICTURES", "page", "run", "section"]
