"""Which columns are the coordinates, and their unit: by the header, by the format, or as the caller says."""

import io
import struct
from collections.abc import Mapping
from typing import Any

import laspy
import numpy as np
import pytest

import primfit
from primfit.app.readers import Pick, UnreadableFileError, read
from primfit.app.readers.columns import as_columns
from primfit.app.readers.las_unit import DEGREES, OTHER, UNEVEN, unit_of
from tests.app.readers.written import e57, las, npy, npz, pcd, ply, records

POINTS = np.random.default_rng(9).normal(size=(9, 3))
ROWS = [",".join(map(repr, row)) for row in POINTS.tolist()]
MIXED = "a,b,c,d\n" + "\n".join(f"7,{row}" for row in ROWS)
WIDE = np.column_stack([np.full(9, 7.0), POINTS])

PICKED: dict[str, tuple[bytes, tuple[Any, ...]]] = {
    "names in a header": (MIXED.encode(), ("b", "c", "d")),
    "numbers beside a header": (MIXED.encode(), (2, "3", 4)),
    "numbers without": (MIXED.partition("\n")[2].encode(), (2, 3, 4)),
    "a header of another width": (MIXED.replace("a,", "", 1).encode(), (2, 3, 4)),
    "an array": (npy(WIDE), (2, 3, 4)),
    "organized records": (npy(records(POINTS[:, ::-1]).reshape(3, 3)), ("z", "y", "x")),
    "an array in an archive": (npz(points=WIDE), (2, 3, 4)),
    "records": (npy(records(POINTS[:, ::-1])), ("z", "y", "x")),
    "a PCD": (pcd(POINTS[:, ::-1], "binary"), ("z", "y", "x")),
    "a PLY": (ply((records(POINTS[:, ::-1]), "vertex")), (3, 2, 1)),
}


@pytest.mark.parametrize(("data", "columns"), PICKED.values(), ids=PICKED)
def test_columns_are_picked_by_name_or_number(data: bytes, columns: tuple[Any, ...]) -> None:
    np.testing.assert_array_equal(read(data, pick=Pick(columns=columns)).points, POINTS)


def test_six_columns_bring_normals() -> None:
    table = np.column_stack([POINTS, np.tile([0.0, 0.0, 2.0], (9, 1))])
    cloud = read(npy(table), pick=Pick(columns=(1, 2, 3, 4, 5, 6)))
    np.testing.assert_array_equal(cloud.normals, np.tile([0.0, 0.0, 1.0], (9, 1)))
    assert cloud.columns == ("1", "2", "3", "4", "5", "6")


@pytest.mark.parametrize(
    ("data", "columns", "message"),
    [
        (MIXED.encode(), ("b", "c", "e"), "there is no such column; the 4 columns are a, b, c, d"),
        (MIXED.encode(), (2, 3, 5), "there is no such column"),
        (MIXED.encode(), ("b", 2, "c"), "two of these columns are the same"),
        (b'{"points": [[1, 2, 3]]}', (1, 2, 3), "JSON has no columns"),
        (b'{"points": [[1, 2, 3]], "options": {"columns": [3, 2, 1]}}', None, "JSON has no columns"),
        (b"v 1 2 3\nv 4 5 6\n", (1, 2, 3), "a mesh has no columns"),
        (e57(POINTS), (1, 2, 3), "nothing to choose"),
    ],
    ids=["name", "number", "twice", "json", "options in json", "obj", "e57"],
)
def test_columns_that_are_not_there_are_named(data: bytes, columns: Any, message: str) -> None:
    with pytest.raises(UnreadableFileError, match=message) as caught:
        read(data, pick=Pick(columns=columns))
    assert caught.value.field == "columns"


@pytest.mark.parametrize(
    "columns", ["1,2", "1,2,3,4", "1,2,2", "1,,3", [1, 2, 0], [1, 2, True], [1.5, 2, 3], 7, {"x": 1}]
)
def test_what_names_no_columns_is_refused(columns: Any) -> None:
    with pytest.raises(primfit.InvalidOptionError, match="columns: ") as caught:
        as_columns(columns)
    assert caught.value.field == "columns"


def test_names_of_surveyors_are_coordinates_where_there_are_no_others() -> None:
    text = "id,Northing,Easting,Elevation\n1,2,3,4\n5,6,7,8\n"
    assert read(text.encode()).points.tolist() == [[3, 2, 4], [7, 6, 8]]
    text = "x,y,z,height\n1,2,3,4\n5,6,7,8\n"
    assert read(text.encode()).points.tolist() == [[1, 2, 3], [5, 6, 7]]


def test_a_table_whose_columns_cannot_be_told_lists_them() -> None:
    with pytest.raises(UnreadableFileError, match=r"among a, b, c, d; .* columns=NAME,NAME,NAME"):
        read(MIXED.encode())


TOLD: dict[str, tuple[bytes, str | None, str | None]] = {
    "in brackets": (b"X [mm],Y [mm],Z [mm]\n1,2,3\n4,5,6\n", "mm", "header"),
    "in words": (
        b"x(inches) y(inches) z(inches)\n1 2 3\n4 5 6\n",
        "inch",
        "header",
    ),
    "in a row": (b"x,y,z\nm,m,m\n1,2,3\n4,5,6\n", "m", "header"),
    "by one of them": (b"X [m],Y,Z\n1,2,3\n4,5,6\n", "m", "header"),
    "in a comment": (b"//X[ft] Y[ft] Z[ft]\n1 2 3\n4 5 6\n", "ft", "header"),
    "nowhere": (b"x,y,z\n1,2,3\n4,5,6\n", None, None),
    "something else in brackets": (b"X (UTM),Y (UTM),Z (UTM)\n1,2,3\n4,5,6\n", None, None),
    "by LAS": (las(), "m", "format"),
    "by E57": (e57(POINTS), "m", "format"),
    "not by PLY": (ply((records(POINTS), "vertex")), None, None),
}


@pytest.mark.parametrize(("data", "unit", "source"), TOLD.values(), ids=TOLD)
def test_the_unit_is_known_where_it_is_told(data: bytes, unit: str | None, source: str | None) -> None:
    cloud = read(data)
    assert (cloud.unit, cloud.unit_from) == (unit, source)


def test_units_that_cannot_be_taken_are_said() -> None:
    for text, message in (
        (b"X [m],Y [m],Z [ft]\n1,2,3\n4,5,6\n", "different units"),
        (b"lon,x [deg],y [deg],z\n1,2,3,4\n4,5,6,7\n", "angles"),
    ):
        with pytest.raises(UnreadableFileError, match=message):
            read(text)
    cloud = read(b"X [yd],Y [yd],Z [yd]\n1,2,3\n4,5,6\n")
    assert cloud.unit is None and "not known" in cloud.warnings[0]


def _keys(**values: int) -> dict[tuple[bytes, int], memoryview]:
    words = [1, 1, 0, len(values), *(w for k, v in values.items() for w in (int(k[1:]), 0, 1, v))]
    return {(b"LASF_Projection", 34735): memoryview(struct.pack(f"<{len(words)}H", *words))}


def _text(text: str) -> dict[tuple[bytes, int], memoryview]:
    return {(b"LASF_Projection", 2112): memoryview(text.encode())}


GEOGRAPHIC = 'GEOGCS["WGS 84",DATUM["D",SPHEROID["S",6378137,298.2]],UNIT["degree",0.0174532925199433]]'
PROJECTED = f'PROJCS["plane",{GEOGRAPHIC},PROJECTION["P"],UNIT["%s",%s],AXIS["E",EAST]]'
FOOT = '"US survey foot",0.304800609601219'
GEODETIC = 'BASEGEOGCRS["g",DATUM["d",ELLIPSOID["GRS 1980",6378137,298.2,LENGTHUNIT["metre",1]]]]'
IN_FEET = (
    f'PROJCRS["plane",{GEODETIC},CONVERSION["c",PARAMETER["False easting",9,LENGTHUNIT["metre",1]]],'
    f'CS[Cartesian,2],AXIS["(E)",east,LENGTHUNIT[{FOOT}]],AXIS["(N)",north,LENGTHUNIT[{FOOT}]]]'
)
HEIGHTS = 'COMPD_CS["both",%s,VERT_CS["up",VERT_DATUM["d",2005],UNIT["metre",1.0]]]'
LAS_UNITS: dict[str, tuple[Mapping[tuple[bytes, int], memoryview], str | None, str]] = {
    "nothing": ({}, None, ""),
    "keys in meters": (_keys(_1024=1, _3076=9001), "m", ""),
    "keys in US survey feet": (_keys(_1024=1, _3076=9003), "us-ft", ""),
    "keys in chains": (_keys(_3076=9097), None, OTHER),
    "keys in degrees": (_keys(_1024=2), None, DEGREES),
    "text in meters": (_text(PROJECTED % ("metre", "1")), "m", ""),
    "text in feet": (_text(PROJECTED % ("foot", "0.3048")), "ft", ""),
    "text in US survey feet": (_text(PROJECTED % ("US survey foot", "0.3048006096012192")), "us-ft", ""),
    "text in degrees": (_text(GEOGRAPHIC), None, DEGREES),
    "text of version 2": (
        _text('PROJCRS["x",BASEGEOGCRS["y",ANGLEUNIT["degree",0.017]],LENGTHUNIT["metre",1.0]]'), "m", ""
    ),
    "text whose ellipsoid is in meters": (_text(IN_FEET), "us-ft", ""),
    "text with heights in the same unit": (_text(HEIGHTS % (PROJECTED % ("metre", "1"))), "m", ""),
    "text with heights in another unit": (_text(HEIGHTS % (PROJECTED % ("foot", "0.3048"))), None, UNEVEN),
    "text with heights, of version 2": (
        _text(f'COMPOUNDCRS["x",{IN_FEET},VERTCRS["h",AXIS["up",up,LENGTHUNIT["metre",1]]]]'), None, UNEVEN
    ),
    "keys with heights in another unit": (_keys(_1024=1, _3076=9003, _4099=9001), None, UNEVEN),
    "text with a number that is none": (_text(PROJECTED % ("metre", "1.2.3")), None, OTHER),
    "text of a single word": (_text(PROJECTED[:7] + "A" * 60_000), None, ""),
    "an empty text": (_text("\0"), None, ""),
}  # fmt: skip


@pytest.mark.parametrize(("held", "unit", "warning"), LAS_UNITS.values(), ids=LAS_UNITS)
def test_the_coordinate_system_of_a_las_tells_its_unit(held: Any, unit: str | None, warning: str) -> None:
    assert unit_of(held) == (unit, warning)


def test_a_las_in_degrees_is_not_in_meters() -> None:
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.vlrs.append(laspy.VLR("LASF_Projection", 2112, "", GEOGRAPHIC.encode()))
    stream = io.BytesIO()
    with laspy.open(stream, "w", header=header, closefd=False) as writer:
        writer.write_points(laspy.ScaleAwarePointRecord.zeros(5, header=header))
    cloud = read(stream.getvalue())
    assert cloud.unit is None and cloud.unit_from is None and cloud.warnings == (DEGREES,)


def test_the_caller_has_the_last_word_on_the_unit() -> None:
    sphere = primfit.Sphere(np.zeros(3), 2.0).surface(*np.random.default_rng(1).random((2, 200)) * 3)
    found = primfit.fit(sphere, unit="mm")
    assert found.unit == "mm" and found.warnings == ()
    assert primfit.fit(sphere * 1e7, unit="mm").warnings == ("The radius is 2e+07 mm: check the unit.",)
    assert primfit.fit(sphere * 1e7).warnings == ()
