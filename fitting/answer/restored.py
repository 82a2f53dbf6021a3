"""An answer in plain values, back as a `Recognition`: what JSON has kept can be shown and exported again."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from types import UnionType
from typing import Annotated, Any, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from ..extents import EXTENTS
from ..extents.values import Extents
from ..names import ANSWER_PARTS
from ..primitives import PRIMITIVES, parameters_of
from ..primitives.primitive import Primitive
from ..uncertainty.values import Uncertainty
from .conformance import Conformance
from .result import Alternative, Attempt, Recognition
from .values import ErrorSummary, NoiseSummary


def restored(answer: Mapping[str, Any]) -> Recognition:
    """The answer of `POST /fit`, `answer`, as the recognition that it was made from, number for number.

    It has no points, and does not know its `inlier_rule`. Raises `KeyError`, `TypeError` or `ValueError` for
    what is no answer.
    """
    receipt = answer["receipt"]
    return Recognition(
        status=answer["status"],
        primitive=_primitive(answer["primitive"]),
        alternatives=tuple(map(_alternative, answer["alternatives"])),
        error=_made(ErrorSummary, answer["error"]),
        noise=_made(NoiseSummary, answer["noise"]),
        attempts=tuple(map(_attempt, answer["attempts"])),
        message=answer["message"],
        n_points=receipt["n_points"],
        active_constraints=answer["active_constraints"],
        extents=_extents(answer["extents"]),
        uncertainty=_made(Uncertainty, answer["uncertainty"]),
        conformance=_made(Conformance, answer["conformance"]),
        include=tuple(receipt["options"].get("include", ANSWER_PARTS)),
        warnings=tuple(answer["warnings"]),
        unit=receipt["unit"],
    )


def _primitive(values: Mapping[str, Any] | None) -> Primitive | None:
    if values is None:
        return None
    names = parameters_of(values["kind"])
    made = PRIMITIVES[values["kind"]](**{name: values[name] for name in names})
    for name in names:
        if isinstance(values[name], list):  # its own normalization may round a unit vector once more
            object.__setattr__(made, name, np.array(values[name], np.float64))
    return made


def _extents(values: Mapping[str, Any] | None) -> Extents | None:
    return None if values is None else _made(EXTENTS[values["kind"]], values)


def _alternative(values: Mapping[str, Any]) -> Alternative:
    primitive = _primitive(values)
    assert primitive is not None
    return Alternative(
        primitive,
        _made(ErrorSummary, values["error"]),
        _extents(values["extents"]),
        _made(Uncertainty, values["uncertainty"]),
        values["evidence"],
    )


def _attempt(values: Mapping[str, Any]) -> Attempt:
    found = {
        "primitive": _primitive(values["primitive"]),
        "error": _made(ErrorSummary, values["error"]),
        "noise": _made(NoiseSummary, values["noise"]),
    }
    return Attempt(**{**values, **found})


def _made(of: Any, value: Any) -> Any:
    """A plain value as the type of a field of an answer: the reverse of `plain`."""
    origin, args = get_origin(of), get_args(of)
    if value is None or of is Any:
        return value
    if origin is Annotated:
        return _made(args[0], value)
    if origin in (Union, UnionType):
        return _made(_fitting(args, value), value)
    if origin is tuple:
        return tuple(_made(args[0], each) for each in value)
    if origin is np.ndarray:
        return np.array(value, np.float64)
    if isinstance(of, type) and is_dataclass(of):
        return of(**{name: _made(hint, value[name]) for name, hint in _hints(of).items()})
    if isinstance(value, dict):
        return {name: _made(args[1], each) for name, each in value.items()}
    return value


def _fitting(args: tuple[Any, ...], value: Any) -> Any:
    """Which of the types of a union a value has that is not None."""
    others = [each for each in args if each is not type(None)]
    if len(others) == 1:
        return others[0]
    return next(each for each in others if (get_origin(each) is tuple) == isinstance(value, list))


@cache
def _hints(of: type) -> dict[str, Any]:
    """The types of its fields."""
    hints = get_type_hints(of, include_extras=True)
    return {field.name: hints[field.name] for field in fields(cast(Any, of))}
