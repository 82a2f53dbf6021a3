"""The options of the tools are those of the service, in a schema that stands by itself."""

import json

import pytest

from primfit.app.agents import options
from primfit.app.exports import ExportOptions
from primfit.app.wire.problems import InvalidOptionsError
from primfit.app.wire.schemas import FitOptions


def test_the_schema_names_all_options_of_a_fit_without_references() -> None:
    schema = options.fit_schema()
    assert list(schema["properties"]) == list(FitOptions.model_fields)
    assert "$ref" not in json.dumps(options.export_schema())
    assert all(each["description"] for each in options.export_schema()["properties"].values())
    assert schema["properties"]["kinds"]["items"]["enum"] == list(FitOptions.model_fields["kinds"].default)
    assert schema["properties"]["max_error"]["maximum"] == 1


def test_the_examples_of_objects_are_valid() -> None:
    for name, each in options.fit_schema()["properties"].items():
        for example in each.get("examples") or ():
            assert options.checked({name: example})


def test_options_of_an_export_stand_among_those_of_the_fit() -> None:
    fit, export = options.split({"unit": "mm", "chord_error": 0.01, "title": "part 7"})
    assert fit == {"unit": "mm"} and export == ExportOptions(chord_error=0.01, title="part 7")


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"chord_error": 1.0}, "options.chord_error"),
        ({"colour": 1}, "options.colour"),
        ({"seed": -1}, "options.seed"),
    ],
)
def test_a_bad_option_is_named(given: dict[str, object], field: str) -> None:
    with pytest.raises(InvalidOptionsError) as caught:
        options.split(given)
    assert [error.field for error in caught.value.errors] == [field]


def test_artifacts_are_known_ones() -> None:
    assert options.check_artifacts(["step", "csv", "step"]) == ("step", "csv")
    for bad in ([], ["dxf"]):
        with pytest.raises(InvalidOptionsError, match="artifacts"):
            options.check_artifacts(bad)
