"""The JSON body: strict, quick to refuse, and each refusal names the place."""

import pytest

from primfit.app.readers import (
    InvalidPointsError,
    Limits,
    TooLargeError,
    UnreadableFileError,
    json_points,
    read_json,
)


def _points(rows: str) -> bytes:
    return b'{"points": [[0, 0, 0], [1, 2.5, -3e-2]' + f", {rows}]}}".encode()


REFUSED = {
    "nan": (_points("[1, nan, 3]"), "points[2][1]", "NaN"),
    "inf": (_points("[1, 2, inf]"), "points[2][2]", "infinity"),
    "-NaN": (_points("[-NaN, 2, 3]"), "body", None),
    "NaN in labels": (b'{"points": [[1, 2, 3]], "labels": [NaN]}', "labels[0]", "NaN"),
    "1e400": (_points("[1, 2, 1e400]"), "points[2][2]", "number of 5 characters"),
    "integer of 5000 digits": (_points(f"[{'1' * 5000}, 2, 3]"), "points[2][0]", "number of 5000 characters"),
    "nan as string": (_points('["nan", 2, 3]'), "points[2][0]", "string of 3 characters"),
    "number as string": (_points('[1, "2", 3]'), "points[2][1]", "string of 1 characters"),
    "boolean": (_points("[1, 2, true]"), "points[2][2]", "boolean"),
    "object": (_points("[1, 2, {}]"), "points[2][2]", "object"),
    "array": (_points("[1, 2, [3]]"), "points[2][2]", "array of 1"),
    "two coordinates": (_points("[1, 2]"), "points[2]", "array of 2"),
    "four coordinates": (_points("[1, 2, 3, 4]"), "points[2]", "array of 4"),
    "no coordinates": (_points("[]"), "points[2]", "array of 0"),
    "point as object": (_points('{"x": 1, "y": 2, "z": 3}'), "points[2]", "object"),
    "point as string": (_points('"1 2 3"'), "points[2]", "string of 5 characters"),
    "point as null": (_points("null"), "points[2]", "null"),
    "point as number": (_points("7"), "points[2]", "number"),
    "points as string": (b'{"points": "1 2 3"}', "points", "string of 5 characters"),
    "points as object": (b'{"points": {}}', "points.dtype", "missing"),
    "points as null": (b'{"points": null}', "points", "null"),
    "points nested three deep": (b'{"points": [[[1, 2, 3]]]}', "points[0]", "array of 1"),
    "no points": (b"{}", "points", "missing"),
    "points twice": (b'{"points": [], "points": []}', "points", None),
    "an option twice": (b'{"points": [[1, 2, 3]], "options": {"seed": 1, "seed": 2}}', "seed", None),
    "unknown field": (b'{"points": [], "point": []}', "point", None),
    "options as array": (b'{"points": [[1, 2, 3]], "options": []}', "options", "array of 0"),
    "bare array": (b"[[1, 2, 3]]", "body", "array of 1"),
    "bare number": (b"1", "body", "number"),
    "empty": (b"", "body", None),
    "text": (b"x,y,z", "body", None),
    "cut": (b'{"points": [[1, 2, 3], [4', "points[1][0]", None),
    "trailing comma": (b'{"points": [[1, 2, 3],]}', "points[0]", None),
    "no utf-8": (b'{"points": [["\xff", 2, 3]]}', None, None),
    "utf-16": ('{"points": []}'.encode("utf-16"), None, None),
    "lone surrogate": (b'{"points": [["\\ud800", 2, 3]]}', None, None),
    "depth of 100,000": (b'{"points": ' + b"[" * 100_000 + b"]" * 100_000 + b"}", "body", None),
    "depth of objects": (b'{"points": ' * 100_000, "body", None),
    "unclosed strings": (b'{"points": [' + b'"' * 100_001, None, None),
}


@pytest.mark.parametrize(("body", "field", "value"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_a_cloud_is_refused_and_the_place_named(
    body: bytes, field: str | None, value: str | None
) -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read_json(memoryview(body), Limits(json_points=200_000))
    if field is not None:
        assert caught.value.errors[0].field == field
    if value is not None:
        assert caught.value.errors[0].value == value


def test_numbers_in_options_are_not_called_points() -> None:
    for number in (b"NaN", b"1e400"):
        with pytest.raises(UnreadableFileError) as caught:
            read_json(memoryview(b'{"points": [], "options": {"max_error": %s}}' % number))
        assert not isinstance(caught.value, InvalidPointsError)
        assert caught.value.field == "options.max_error"


def test_numbers_are_read_to_the_last_digit() -> None:
    cloud = read_json(
        memoryview(b'{"points": [[0.1, 1e308, -5e-324], [1, 9007199254740993, -0]], "options": {"seed": 1}}')
    )
    assert cloud.points.tolist() == [[0.1, 1e308, -5e-324], [1.0, 9007199254740992.0, 0.0]]
    assert cloud.options == {"seed": 1}


@pytest.mark.parametrize("row", [b'["a", 1]', b'{"x": 1}', b"[1, 2, true]", b"[]", b'"x"'])
def test_a_hundred_thousand_bad_rows_are_counted_and_few_of_them_described(
    row: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    explained: list[str] = []
    explain = json_points._explain_row
    monkeypatch.setattr(
        json_points, "_explain_row", lambda field, row: explained.append(field) or explain(field, row)
    )
    body = b'{"points": [' + b",".join([row] * 100_000) + b"]}"
    with pytest.raises(UnreadableFileError, match="100000 of 100000") as caught:
        read_json(memoryview(body), Limits(json_points=200_000))
    assert len(caught.value.errors) == 20
    assert len(explained) <= 20


@pytest.mark.parametrize("item", [b"[0,0,0]", b"[]", b"0", b"{}", b'""'])
def test_more_than_the_limit_is_refused_before_it_is_built(
    item: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(json_points, "_parse", lambda body: pytest.fail("it was built"))
    body = b'{"points": [' + b",".join([item] * 5_000_000) + b"]}"
    with pytest.raises(TooLargeError, match="limit is 200000 points"):
        read_json(memoryview(body), Limits(json_points=200_000))


def test_one_point_over_the_limit_is_refused() -> None:
    body = b'{"points": [[1, 2, 3], [4, 5, 6], [7, 8, 9]]}'
    assert len(read_json(memoryview(body), Limits(json_points=3)).points) == 3
    with pytest.raises(TooLargeError, match="3 points; the limit is 2"):
        read_json(memoryview(body), Limits(json_points=2))


@pytest.mark.parametrize("text", [b'{"a]:\x00": 1}', b'{"points": [[1, 2, 3]], "o]]],:\x01'])
def test_a_string_that_breaks_off_is_refused_whatever_it_holds(text: bytes) -> None:
    with pytest.raises(UnreadableFileError, match="not valid JSON at character"):
        read_json(memoryview(text))


def test_unknown_fields_are_named() -> None:
    with pytest.raises(UnreadableFileError, match=r"unknown fields: 'seed', 'unit'; allowed are points, "):
        read_json(memoryview(b'{"points": [[1, 2, 3]], "seed": 3, "unit": "mm"}'), Limits())
