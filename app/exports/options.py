"""What an export may be asked for."""

from dataclasses import dataclass
from typing import Literal, get_args

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.request.values import number

Unit = Literal["mm", "m", "inch"]
UNITS: tuple[str, ...] = get_args(Unit)
SMALLEST_ERROR, LARGEST_ERROR = 1e-5, 0.1


@dataclass(frozen=True)
class ExportOptions:
    """Options of an export; a value out of range raises `InvalidOptionError`.

    Attributes
    ----------
    unit : what the coordinates are in; STEP files say so, and nothing is converted
    chord_error : largest distance of a mesh from its surface, as a share of the size of the trimmed shape
    """

    unit: Unit = "mm"
    chord_error: float = 1e-3

    def __post_init__(self) -> None:
        if self.unit not in UNITS:
            raise InvalidOptionError(f"unit is {self.unit!r:.40}; allowed are {', '.join(UNITS)}", "unit")
        if not SMALLEST_ERROR <= number("chord_error", self.chord_error) <= LARGEST_ERROR:
            raise InvalidOptionError(
                f"chord_error is {self.chord_error:g}; it is a share of the size in "
                f"[{SMALLEST_ERROR:g}, {LARGEST_ERROR:g}]",
                "chord_error",
            )
