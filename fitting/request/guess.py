"""A primitive that the caller gives as plain values, as it stands in an answer."""

from collections.abc import Mapping
from typing import Any

from ..errors import InvalidOptionError
from ..names import KINDS
from ..primitives import DIRECTIONS, PRIMITIVES, VECTORS, is_angle, parameters_of
from ..primitives.primitive import Primitive
from ..words import as_given
from .constraints import LARGEST_ANGLE, SMALLEST_ANGLE, angle_error
from .values import direction, positive, triple


def guess_of(values: object) -> Primitive:
    """The primitive of `{"kind": "sphere", "center": [x, y, z], "radius": r}`, or `InvalidOptionError`."""
    kind, values = kind_of("initial_guess", values)
    names = parameters_of(kind)
    if set(values) != {"kind", *names}:
        raise InvalidOptionError(
            f"initial_guess holds {', '.join(sorted(map(str, values)))}; "
            f"a {kind} has kind, {', '.join(names)}",
            "initial_guess",
        )
    given = {name: _value(name, values[name]) for name in names}
    try:
        return PRIMITIVES[kind](**given)
    except ValueError as error:
        raise InvalidOptionError(f"initial_guess is no {kind}: {error}", "initial_guess") from error


def kind_of(field: str, values: object) -> tuple[str, Mapping[str, Any]]:
    """The kind that plain values name, and these; `InvalidOptionError` where it is missing or unknown."""
    if not isinstance(values, Mapping):
        raise InvalidOptionError(f"{field} is {values!r:.40}; a primitive with its kind is needed", field)
    kind = values.get("kind")
    if kind not in KINDS:
        raise InvalidOptionError(
            f"{field}.kind is {kind!r:.40}; allowed are {', '.join(KINDS)}", f"{field}.kind"
        )
    return str(kind), values


def _value(name: str, value: object) -> Any:
    field = f"initial_guess.{name}"
    if name in DIRECTIONS:
        return direction(field, value)
    if name in VECTORS:
        return triple(field, value)
    result = positive(field, value)
    if is_angle(name) and not SMALLEST_ANGLE <= result <= LARGEST_ANGLE:
        raise angle_error(field, as_given(result))
    return result
