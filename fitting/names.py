"""Names that callers use, spelt once. Nothing slow is imported here: the command line asks, too."""

from typing import Literal, get_args

KindName = Literal["plane", "sphere", "cylinder", "cone", "torus"]
KINDS: tuple[KindName, ...] = get_args(KindName)
"""From the simplest to the most general; `fitting.primitives` has a file of this name for each."""

Criterion = Literal[
    "robust",
    "least_squares",
    "huber",
    "tukey",
    "minimum_zone",
    "minimum_circumscribed",
    "maximum_inscribed",
]
CRITERIA: tuple[Criterion, ...] = get_args(Criterion)

AnswerPart = Literal["extents", "uncertainty"]
ANSWER_PARTS: tuple[AnswerPart, ...] = get_args(AnswerPart)
"""The parts of an answer that take time of their own and may be left out."""

Missing = Literal["drop", "error"]
MISSING: tuple[Missing, ...] = get_args(Missing)
"""What becomes of points that are missing."""

Unit = Literal["um", "mm", "cm", "m", "km", "inch", "ft", "us-ft"]
UNITS: tuple[Unit, ...] = get_args(Unit)
"""Units of length: micrometers to kilometers, and international and US survey feet."""

CRITERION: Criterion = "robust"
SEED = 0
"""The defaults of `criterion` and `seed`; all kinds are allowed, all parts answered, and other options not
set."""
