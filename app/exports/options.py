"""What an export may be asked for."""

from collections.abc import Iterable
from dataclasses import dataclass

from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.names import KINDS, UNITS, KindName, Unit
from primfit.fitting.request.values import number

LONGEST = 200
ABOUT = ("title", "operator", "date")
SMALLEST_ERROR, LARGEST_ERROR = 1e-5, 0.1


@dataclass(frozen=True)
class ExportOptions:
    """Options of an export; a value out of range raises `InvalidOptionError`.

    Attributes
    ----------
    unit : of the coordinates; None for that of the answer, which no other one may contradict. STEP files need
        one, and a GLB is in meters where it is known; nothing else is converted
    export_kind : which of the kinds of an ambiguous answer; None for the first
    chord_error : largest distance of a mesh from its surface, as a share of the size of the trimmed shape
    title, operator, date : what the report says of itself, as given; it guesses none of them
    """

    unit: Unit | None = None
    chord_error: float = 1e-3
    export_kind: KindName | None = None
    title: str | None = None
    operator: str | None = None
    date: str | None = None

    def __post_init__(self) -> None:
        if self.unit not in (None, *UNITS):
            raise InvalidOptionError(f"unit is {self.unit!r:.40}; allowed are {', '.join(UNITS)}", "unit")
        if self.export_kind not in (None, *KINDS):
            raise InvalidOptionError(
                f"export_kind is {self.export_kind!r:.40}; allowed are {', '.join(KINDS)}", "export_kind"
            )
        if not SMALLEST_ERROR <= number("chord_error", self.chord_error) <= LARGEST_ERROR:
            raise InvalidOptionError(
                f"chord_error is {self.chord_error:g}; it is a share of the size in "
                f"[{SMALLEST_ERROR:g}, {LARGEST_ERROR:g}]",
                "chord_error",
            )
        for name in ABOUT:
            _check_text(name, getattr(self, name))


def known_unit(unit: Unit | None) -> Unit:
    """The unit; raises `InvalidOptionError` where it is not known."""
    if unit is None:
        raise InvalidOptionError(
            f"unit is not known, and a STEP file needs one; give it, out of {', '.join(UNITS)}", "unit"
        )
    return unit


def unit_of(answers: Iterable[Recognition], asked: Unit | None) -> Unit | None:
    """The one unit of some answers, and of what is written about them; None where it is not known.

    Raises `InvalidOptionError` where they are in different units, or in another one than was asked for:
    numbers keep their unit.
    """
    units = {answer.unit for answer in answers}
    told = ", ".join(sorted(unit or "none" for unit in units))
    if asked is not None:
        if units - {None, asked}:
            raise InvalidOptionError(
                f"unit is {asked}, but the fit was in {told}; nothing is converted: give the unit to the fit",
                "unit",
            )
        return asked
    if len(units) > 1:
        raise InvalidOptionError(f"the answers are in different units ({told}); fit them with one", "unit")
    return next(iter(units), None)


def _check_text(name: str, text: object) -> None:
    """A line that a report shows."""
    if text is None:
        return
    if not isinstance(text, str):
        raise InvalidOptionError(f"{name} is of type {type(text).__name__}; it is a text", name)
    if len(text) > LONGEST:
        raise InvalidOptionError(
            f"{name} is {len(text)} characters long; at most {LONGEST} are allowed", name
        )
    if not text.isprintable():
        raise InvalidOptionError(f"{name} holds line breaks or other characters that cannot be printed", name)
