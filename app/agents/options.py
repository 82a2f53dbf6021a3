"""The options that tools take: those of a fit, and of an export, in a schema without references."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from primfit.fitting.errors import InvalidOptionError

from ..exports import FORMATS, ExportOptions
from ..exports.options import ABOUT, LARGEST_ERROR, SMALLEST_ERROR
from ..readers.errors import FieldError
from ..wire.artifacts import NAMES
from ..wire.options import check_options
from ..wire.problems import InvalidOptionsError
from ..wire.schemas import FitOptions

_OF_EXPORT = NAMES[1:]
_EXAMPLES: dict[str, Any] = {
    "constraints": [{"radius": {"min": 4, "max": 6}, "axis": {"direction": [0, 0, 1], "max_angle": 0.05}}],
    "initial_guess": [{"kind": "sphere", "center": [0, 0, 0], "radius": 5}],
}


@cache
def fit_schema() -> dict[str, Any]:
    """JSON schema of the options of a fit; what may be in an object is shown by an example."""
    schema = FitOptions.model_json_schema()
    properties = {name: _alone(name, each, schema["$defs"]) for name, each in schema["properties"].items()}
    return {"type": "object", "properties": properties, "additionalProperties": False}


@cache
def export_schema() -> dict[str, Any]:
    """That of the options of a fit and of an export."""
    kinds = fit_schema()["properties"]["kinds"]["items"]
    chord = "largest distance of a mesh from the surface, as a share of its size"
    properties = {
        **fit_schema()["properties"],
        "chord_error": {
            "type": "number",
            "minimum": SMALLEST_ERROR,
            "maximum": LARGEST_ERROR,
            "default": ExportOptions.chord_error,
            "description": chord,
        },
        "export_kind": {**kinds, "description": "which kind of an ambiguous answer; by default the first"},
        **{name: {"type": "string", "description": "printed on the report"} for name in ABOUT},
    }
    return {**fit_schema(), "properties": properties}


def checked(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """The options of a fit; raises `InvalidOptionsError` with every mistake."""
    return check_options((), options or {})


def split(options: Mapping[str, Any] | None) -> tuple[dict[str, Any], ExportOptions]:
    """The options of the fit, and those of the export; raises `InvalidOptionsError`."""
    given = dict(options or {})
    how = {name: given.pop(name) for name in _OF_EXPORT if name in given}
    try:
        return checked(given), ExportOptions(**how)
    except InvalidOptionError as error:
        raise InvalidOptionsError([FieldError(f"options.{error.field}", str(error))]) from None


def check_artifacts(artifacts: list[str]) -> tuple[str, ...]:
    """The artifacts, each once; raises `InvalidOptionsError` where there is none, or one is unknown."""
    allowed = ", ".join(FORMATS)
    errors = [
        FieldError(f"artifacts[{i}]", f"unknown artifact; allowed are {allowed}")
        for i, name in enumerate(artifacts)
        if name not in FORMATS
    ]
    if not artifacts:
        errors.append(FieldError("artifacts", f"is missing; name some of {allowed}"))
    if errors:
        raise InvalidOptionsError(errors)
    return tuple(dict.fromkeys(artifacts))


def _alone(name: str, described: Mapping[str, Any], definitions: Mapping[str, Any]) -> dict[str, Any]:
    """A property without references: lists and names as they are, of an object an example."""
    rest = {key: value for key, value in described.items() if key in ("description", "default", "examples")}
    shape = _resolved(described, definitions)
    if shape.get("type") == "object" or "oneOf" in shape:
        examples = _EXAMPLES.get(name, rest.get("examples"))
        return {"type": "object", "examples": examples, "description": rest["description"]}
    if "items" in shape:
        shape = {**shape, "items": _resolved(shape["items"], definitions)}
    told = ("type", "enum", "items", "minItems", "maxItems", "minimum", "exclusiveMinimum", "maximum")
    return {key: shape[key] for key in told if key in shape} | rest


def _resolved(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> dict[str, Any]:
    """The schema that a value has to match where there is one, behind references and beside null."""
    options = [each for each in schema.get("anyOf", []) if each != {"type": "null"}]
    chosen = dict(options[0]) if len(options) == 1 else dict(schema)
    reference = chosen.get("$ref", "").rpartition("/")[2]
    return dict(definitions[reference]) if reference else chosen
