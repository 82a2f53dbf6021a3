"""Models of the wire from dataclasses: their fields, and what their NumPy docstrings say of each.

A shape in the docstring says what an array is: `(3,)`, or nothing, is a vector, `(K, 3)` a list of them, and
any other pair of letters a matrix.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import reduce
from inspect import cleandoc
from operator import or_
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, create_model

Vector = Annotated[
    list[float], Field(min_length=3, max_length=3, description="[x, y, z]", examples=[[0.0, 0.0, 1.0]])
]
CLOSED = ConfigDict(extra="forbid")

_SHAPE = re.compile(r"\s*\((3,|[A-Z], 3|[A-Z], [A-Z])\)")
_ENTRY = re.compile(r"^(?P<names>\w+(?:, \w+)*) :(?P<text>.*(?:\n +.*)*)", re.M)


class Models:
    """The models made so far, which the fields of others refer to."""

    def __init__(self) -> None:
        self._known: dict[Any, Any] = {}

    def stands_for(self, type_: Any, model: Any) -> Any:
        """Let a type be this model wherever a field has it."""
        self._known[type_] = model
        return model

    def model(
        self,
        of: type,
        name: str | None = None,
        without: Sequence[str] = (),
        base: type[BaseModel] | None = None,
        config: ConfigDict | None = None,
        optional: bool = False,
        doc: str | None = None,
        **instead: Any,
    ) -> Any:
        """The model of a dataclass; its `kind`, where it has one, comes first.

        Parameters
        ----------
        of : the dataclass; fields that refer to another one need that one's model first
        name : of the model, in place of that of the dataclass
        without : fields that are left out
        base : a model whose fields come first
        config : of the model, as that of one that is closed to other fields
        optional : fields may be left out, and stand at None then
        doc : what it is, in place of the docstring
        instead : types of fields, in place of those of the dataclass
        """
        hints, said = get_type_hints(of), descriptions(of)
        made: dict[str, Any] = {}
        for name_ in (field.name for field in fields(of) if field.name not in without):
            text = said.get(name_, "")
            type_ = instead.pop(name_, None) or self._type(hints[name_], _shape(text))
            made[name_] = (type_, _field(None if optional else ..., text))
        made |= {name_: (type_, ...) for name_, type_ in instead.items()}
        name, doc = name or of.__name__, doc or prose(of)
        if base is not None:
            return create_model(name, __base__=base, __doc__=doc, **made)
        return self.stands_for(of, create_model(name, __config__=config, __doc__=doc, **_kind(of), **made))

    def _type(self, hint: Any, shape: str | None) -> Any:
        """The type on the wire of a field."""
        origin = get_origin(hint)
        if hint in self._known or origin is Literal:
            return self._known.get(hint, hint)
        if origin is np.ndarray:
            return _array(shape)
        if is_dataclass(hint):
            raise TypeError(f"the model of {hint} comes too late")
        inner = [self._type(each, shape) for each in get_args(hint)]
        if origin is tuple:
            return list[inner[0]] if inner[1] is ... else Vector  # type: ignore[valid-type]
        if origin is Mapping:
            return dict[inner[0], inner[1]]  # type: ignore[valid-type]
        return reduce(or_, inner) if inner else hint


def union(models: Iterable[Any]) -> Any:
    """One of several models, told apart by their `kind`."""
    return Annotated[Union[tuple(models)], Field(discriminator="kind")]  # noqa: UP007


def prose(of: type) -> str:
    """What a docstring says before its sections."""
    return _plain(re.split(r"\n\n\w+\n-+\n", _doc(of))[0])


def descriptions(of: type) -> dict[str, str]:
    """What the `Attributes` in the docstrings of a class and of those before it say of each name."""
    said: dict[str, str] = {}
    for each in reversed(of.__mro__):
        section = re.search(r"\nAttributes\n-+\n(.*?)(?:\n\n|\Z)", _doc(each), re.S)
        for entry in _ENTRY.finditer(section[1] if section else ""):
            said |= dict.fromkeys(entry["names"].split(", "), " ".join(entry["text"].split()))
    return said


def _doc(of: type) -> str:
    return cleandoc(of.__dict__.get("__doc__") or "")


def _shape(text: str) -> str | None:
    found = _SHAPE.search(text)
    return found[1] if found else None


def _array(shape: str | None) -> Any:
    """The type on the wire of an array."""
    if shape is None or shape == "3,":
        return Vector
    return list[Vector] if shape.endswith(" 3") else list[list[float]]


def _kind(of: Any) -> dict[str, Any]:
    """The field `kind` of what has one."""
    kind = getattr(of, "kind", None)
    return {"kind": (Literal[kind], ...)} if isinstance(kind, str) else {}


def _field(default: Any, text: str) -> Any:
    """A field with its description, if there is one: without shapes, in words of JSON."""
    told = _plain(_SHAPE.sub("", text)).strip()
    return Field(default, description=told) if told else Field(default)


def _plain(text: str) -> str:
    return re.sub(r"\bNone\b", "null", text.replace(". None ", ". Null "))
