"""Tables of plain numbers, read in their own way: what is found is what the way for any table finds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from primfit.app.readers.columns import FOUND, Pick
from primfit.app.readers.errors import UnreadableFileError
from primfit.app.readers.plain import load_plain
from primfit.app.readers.tables import look
from primfit.app.readers.text import _load_any, read_text

NUMBERS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.floats(-1e4, 1e4).map("{:.6f}".format),
    st.floats(-1e4, 1e4).map("{:.18e}".format),
    st.integers(-(10**25), 10**25).map(str),
)
ODD = st.sampled_from(
    ["nan", "", "1.", "+2.5", ".5", "07", "1e999", '"3"', "true", "null", "[1]", "1 2", "x", "-"]
)
LABELS = st.one_of(st.integers(-5, 2 * 10**18).map(str), st.sampled_from(["1.0", "wall", "2e0", "-0"]))


@st.composite
def tables(draw: st.DrawFn) -> bytes:
    """Rows x, y, z and label below their names; now and then a cell is no plain number, or there is none."""
    cut = draw(st.sampled_from([",", ";", "\t", " ", ", ", "  "]))
    rows = draw(st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS, LABELS), min_size=2, max_size=12))
    lines = [cut.join(row) for row in [("x", "y", "z", "label"), *rows]]
    if draw(st.booleans()):
        at = draw(st.integers(2, len(lines)))
        odd = cut.join([draw(ODD), *draw(st.lists(st.one_of(ODD, NUMBERS), max_size=4))])
        lines.insert(at, draw(st.sampled_from([odd, "", "# cut here", "  ", "1" + cut])))
    end = draw(st.sampled_from(["\n", "\r\n", "\n\n"]))
    return (draw(st.sampled_from(["", "# scan 7\n\n", "\ufeff"])) + end.join(lines) + end).encode()


@settings(max_examples=300, deadline=None)
@given(tables(), st.booleans())
def test_numbers_are_those_that_any_table_gives(text: bytes, labeled: bool) -> None:
    """To the last bit, and only where any table gives some."""
    try:
        layout = look(text, Pick(labels="label") if labeled else FOUND)
    except UnreadableFileError:
        return
    if (plain := load_plain(text, layout)) is None:
        return
    table, labels = _load_any(text, layout, [])
    np.testing.assert_array_equal(plain[0], table)
    assert (plain[1] is None) == (labels is None)
    if labels is not None:
        assert plain[1] is not None and plain[1].dtype == labels.dtype
        np.testing.assert_array_equal(plain[1], labels)


@pytest.mark.parametrize(
    "text",
    [
        b"x,y,z\n1.5,2,-3e-7\n4,5.25,6\n",
        b"x;y;z\r\n1.5;2;-3e-7\r\n4;5.25;6\r\n",
        b"# x y z\n  1.5\t2 -3e-7\n4 5.25   6",
        b"2\n1.5 2 -3e-7\n4 5.25 6\n",
    ],
    ids=["commas", "semicolons and CRLF", "white space", "PTS"],
)
def test_usual_tables_are_plain(text: bytes) -> None:
    layout = look(text, FOUND)
    plain = load_plain(text, layout)
    assert plain is not None
    np.testing.assert_array_equal(plain[0][:, -3:], [[1.5, 2, -3e-7], [4, 5.25, 6]])
    assert read_text(memoryview(text)).warnings == ()


def test_a_wrong_count_is_told_of_a_plain_table() -> None:
    cloud = read_text(memoryview(b"3\n1.5 2 -3e-7\n4 5.25 6\n"))
    assert cloud.warnings == ("The first line announces 3 points, 2 follow; all are read.",)


def test_a_table_of_several_pieces_is_whole() -> None:
    points = np.random.default_rng(5).normal(size=(40_000, 3))
    text = "".join(f"{x!r},{y!r},{z!r},{i}\n" for i, (x, y, z) in enumerate(points.tolist())).encode()
    layout = look(b"x,y,z,label\n" + text, Pick(labels="label"))
    plain = load_plain(b"x,y,z,label\n" + text, layout)
    assert plain is not None and plain[1] is not None
    np.testing.assert_array_equal(plain[0], points)
    np.testing.assert_array_equal(plain[1], np.arange(40_000))
