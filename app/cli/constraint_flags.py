"""`--constraint NAME=VALUE` as the constraints that JSON spells out.

A number is `radius=5`, or `radius=4..6` with either end left out; a direction is `axis=0,0,1`, or
`axis=0,0,1@0.05` with the largest angle [rad]; a position is `center=1,2,3`.
"""

from collections.abc import Sequence
from typing import Any, get_type_hints

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.request.constraints import Constraints, Direction, Range
from primfit.fitting.request.values import Triple

_TYPES = get_type_hints(Constraints)


def parse_constraints(flags: Sequence[str]) -> dict[str, Any]:
    """The mapping that `fit` takes; raises `InvalidOptionError` for what cannot be read."""
    constraints: dict[str, Any] = {}
    for flag in flags:
        name, equals, text = flag.partition("=")
        if not equals:
            raise InvalidOptionError(f"constraint {flag!r:.40} is not NAME=VALUE", "constraint")
        if name in constraints:
            raise InvalidOptionError(f"constraint {name:.40} is given more than once", "constraint")
        constraints[name] = _value(name, text)
    return constraints


def _value(name: str, text: str) -> Any:
    """The value in plain form; of a name that is not known the text, which `Constraints.of` refuses."""
    type_ = _TYPES.get(name)
    if type_ == Triple | None:
        return _numbers(name, text)
    if type_ == Direction | None:
        direction, at, angle = text.partition("@")
        return {"direction": _numbers(name, direction)} | ({"max_angle": _number(name, angle)} if at else {})
    if type_ != Range | None:
        return text
    low, dots, high = text.partition("..")
    if not dots:
        return {"value": _number(name, text)}
    ends = {"min": low, "max": high}
    return {end: _number(name, number) for end, number in ends.items() if number}


def _numbers(name: str, text: str) -> list[float]:
    return [_number(name, part) for part in text.split(",")]


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InvalidOptionError(
            f"constraint {name:.40} holds {text!r:.40}, which is not a number", "constraint"
        ) from None
