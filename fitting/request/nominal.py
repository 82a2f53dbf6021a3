"""What a primitive should be: nominal parameters, and how far those that were measured may deviate."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from ..errors import InvalidOptionError
from ..primitives import DIRECTIONS, VECTORS, parameters_of
from .guess import kind_of
from .values import LARGEST, Triple, direction, number, positive, triple


@dataclass(frozen=True)
class Target:
    """A nominal parameter, and the deviations from it that are allowed.

    Attributes
    ----------
    value : a number [length or rad], a direction, or a position [length]
    lower, upper : of the deviation; None where it is only reported. Of a direction [rad] or a position, whose
        deviations are not negative, 0 and the largest allowed
    """

    value: float | Triple
    lower: float | None = None
    upper: float | None = None

    def plain(self) -> dict[str, Any]:
        """The values that `Nominal.of` takes."""
        value = list(self.value) if isinstance(self.value, tuple) else self.value
        if self.lower is None or self.upper is None:
            return {"value": value}
        both = [self.lower, self.upper]
        symmetric = self.lower in (-self.upper, 0.0) and (isinstance(value, list) or self.lower != 0.0)
        return {"value": value, "tolerance": self.upper if symmetric else both}


@dataclass(frozen=True)
class Nominal:
    """A primitive, or some of its parameters, with tolerances.

    Attributes
    ----------
    kind : one of `KINDS`
    targets : by the name of the parameter
    """

    kind: str
    targets: Mapping[str, Target] = field(default_factory=dict)

    @classmethod
    def of(cls, values: object) -> Self:
        """From plain values: `{"kind": "cylinder", "radius": {"value": 25, "tolerance": 0.05}}`.

        A parameter is its value, or an object with `value` and `tolerance`: how far it may deviate to either
        side, or of a number `[lower, upper]`. All but `kind` may be left out, so a primitive of an answer is
        taken, too.

        Raises `InvalidOptionError` for anything else.
        """
        if isinstance(values, Nominal):
            return cls(values.kind, values.targets)
        kind, values = kind_of("nominal", values)
        names = parameters_of(kind)
        for name in values:
            if name != "kind" and name not in names:
                raise InvalidOptionError(
                    f"nominal holds {name!r:.40}; a {kind} has {', '.join(names)}", "nominal"
                )
        return cls(kind, {name: _target(name, values[name]) for name in names if name in values})

    def plain(self) -> dict[str, Any]:
        """The values that `of` takes."""
        return {"kind": self.kind, **{name: target.plain() for name, target in self.targets.items()}}


def _target(name: str, given: object) -> Target:
    where = f"nominal.{name}"
    if not isinstance(given, Mapping):
        return Target(_value(name, where, given))
    for key in given:
        if key not in ("value", "tolerance"):
            raise InvalidOptionError(f"{where} holds {key!r:.40}; allowed are value, tolerance", where)
    if "value" not in given:
        raise InvalidOptionError(f"{where} needs a value", where)
    value = _value(name, f"{where}.value", given["value"])
    if given.get("tolerance") is None:
        return Target(value)
    lower, upper = _limits(f"{where}.tolerance", given["tolerance"], vector=name in VECTORS)
    return Target(value, lower, upper)


def _value(name: str, where: str, given: object) -> float | Triple:
    if name in DIRECTIONS:
        return direction(where, given)
    return triple(where, given) if name in VECTORS else positive(where, given)


def _limits(where: str, given: object, vector: bool) -> tuple[float, float]:
    """The least and the largest deviation that are allowed."""
    if vector or isinstance(given, str) or not isinstance(given, Iterable):
        most = number(where, given)
        if not 0.0 <= most <= LARGEST:
            raise InvalidOptionError(f"{where} is {most:g}; it must not be negative", where)
        return 0.0 if vector else -most, most
    limits = [number(where, each) for each in given]
    if len(limits) != 2 or not -LARGEST <= limits[0] <= limits[1] <= LARGEST:
        raise InvalidOptionError(f"{where} must be a number, or [lower, upper] in this order", where)
    return limits[0], limits[1]
