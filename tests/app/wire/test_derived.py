"""Models of the wire made of dataclasses: types, descriptions, and what they refuse."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Literal

import pytest
from pydantic import TypeAdapter, ValidationError

from primfit.app.wire import schemas
from primfit.app.wire.derived import CLOSED, Models, union
from primfit.fitting.extents import EXTENTS
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import PRIMITIVES


@dataclass
class Sized:
    """What has a size.

    Attributes
    ----------
    size : [length]
    """

    size: float


@dataclass
class Ellipsoid(Sized):
    """A sixth kind. None where it cannot be.

    It is not one of revolution.

    Attributes
    ----------
    center : (3,)
    first, second : (3,) half axes; None of a sphere
    outline : (K, 3) corners, as they come
        one after the other
    rings : of each the corners (K, 3), and so on
    spread : (P, P) of the numbers

    Notes
    -----
    outline : is no longer said here
    """

    kind: ClassVar[str] = "prism"

    center: Array
    first: Array | None
    second: Array | None
    outline: Array
    rings: tuple[tuple[Array, ...], ...]
    spread: Array | None
    how: Literal["one", "other"]
    by_name: Mapping[str, Sized]


def _schema(model: Any) -> dict[str, Any]:
    return TypeAdapter(model).json_schema()


def _model() -> Any:
    wire = Models()
    wire.model(Sized)
    return wire.model(Ellipsoid, config=CLOSED)


def test_types_follow_the_fields_and_the_shapes() -> None:
    schema = _schema(_model())
    of = schema["properties"]
    vector = {"items": {"type": "number"}, "minItems": 3, "maxItems": 3, "type": "array"}
    assert of["kind"]["const"] == "prism" and schema["required"] == list(of)
    assert vector.items() <= of["center"].items()
    assert vector.items() <= of["first"]["anyOf"][0].items() and of["first"]["anyOf"][1] == {"type": "null"}
    assert vector.items() <= of["outline"]["items"].items()
    assert vector.items() <= of["rings"]["items"]["items"]["items"].items()
    assert of["spread"]["anyOf"][0]["items"] == {"items": {"type": "number"}, "type": "array"}
    assert of["how"]["enum"] == ["one", "other"]
    assert of["by_name"]["additionalProperties"] == {"$ref": "#/$defs/Sized"}
    assert schema["additionalProperties"] is False


def test_descriptions_are_those_of_the_docstring_without_shapes() -> None:
    schema = _schema(_model())
    of = schema["properties"]
    assert schema["description"] == "A sixth kind. Null where it cannot be.\n\nIt is not one of revolution."
    assert of["first"]["description"] == of["second"]["description"] == "half axes; null of a sphere"
    assert of["outline"]["description"] == "corners, as they come one after the other"
    assert of["rings"]["description"] == "of each the corners, and so on"
    assert of["size"]["description"] == "[length]"
    assert of["center"]["description"] == "[x, y, z]" and "description" not in of["how"]


def test_what_the_wire_says_otherwise_comes_first() -> None:
    wire = Models()
    base = wire.model(Sized, "Size")
    made = wire.model(
        Ellipsoid, "More", without=("by_name", "spread"), base=base, optional=True, how=int, beside=str
    )
    schema = _schema(made)
    assert schema["title"] == "More" and schema["required"] == ["beside"]
    assert schema["properties"]["how"]["type"] == "integer"
    assert not {"by_name", "spread", "kind"} & schema["properties"].keys()


def test_a_model_that_comes_too_late_is_refused() -> None:
    with pytest.raises(TypeError, match="Sized"):
        Models().model(Ellipsoid)


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_told_by_its_name_and_closed(kind: str) -> None:
    schema = _schema(schemas.Primitive)
    assert schema["discriminator"]["mapping"].keys() == set(KINDS)
    name = PRIMITIVES[kind].__name__
    assert schema["$defs"][name]["additionalProperties"] is False
    extents = _schema(schemas.Extents)["$defs"][EXTENTS[kind].__name__]
    assert extents["required"] == ["kind", *(field.name for field in fields(EXTENTS[kind]))]
    other = _schema(schemas.Alternative)["$defs"][f"{name}Alternative"]
    assert {"error", "extents", "uncertainty", "evidence"} < set(other["required"])
    with pytest.raises(ValidationError):
        TypeAdapter(schemas.Primitive).validate_python({"kind": kind, "color": 1.0})


def test_a_union_of_one_more_kind_tells_it_apart() -> None:
    known = [schemas._PRIMITIVES[kind] for kind in KINDS]
    schema = _schema(union([*known, _model()]))
    assert schema["discriminator"]["mapping"].keys() == {*KINDS, "prism"}
