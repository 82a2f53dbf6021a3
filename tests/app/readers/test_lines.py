"""The lines of a text are those that Python reads, and what is silent is passed over."""

import io
import re
from itertools import pairwise

import numpy as np
import pytest

from primfit.app.readers import read
from primfit.app.readers.lines import decoded, lines

WORDS = [b"1,2,3", b"", b"  ", b"# x", b"\xc2\xa0", b"\xe2\x80\xa8", b"\xff", b"\xef\xbb\xbf", b"\xc3"]
ANYTHING = re.compile("")
A_ROW = re.compile(r"^\d", re.MULTILINE)


@pytest.mark.parametrize("ends", [[b"\n"], [b"\r\n"], [b"\r"], [b"\n", b"\r\n", b"\r"]], ids=repr)
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["bare", "with a byte order mark"])
def test_lines_are_those_that_python_reads(ends: list[bytes], mark: bytes) -> None:
    """Also where the text is cut into pieces: no cut may come between the two ends of a line of Windows."""
    rng = np.random.default_rng(8)
    drawn = rng.integers((len(WORDS), len(ends)), size=(200_000, 2))
    text = mark + b"first\n" + b"".join(WORDS[word] + ends[end] for word, end in drawn)
    read_by_python = io.TextIOWrapper(io.BytesIO(text.removeprefix(mark)), "utf-8", errors="replace")
    expected = [line.removesuffix("\n") for line in read_by_python]
    assert list(lines(text, ANYTHING)) == [(n, line) for n, line in enumerate(expected, 1) if line]
    assert decoded(text).split("\n") == [*expected, ""]


def test_a_text_without_an_end_has_its_last_line() -> None:
    assert list(lines(b"1\n\n2", A_ROW)) == [(1, "1"), (3, "2")]
    assert list(lines(b"", A_ROW)) == []


@pytest.mark.parametrize("silent", [b"# nothing\n", b"\n", b"  \r\n"], ids=repr)
def test_only_lines_near_a_wanted_one_are_looked_at(silent: bytes) -> None:
    """A line costs a step; of five million bytes between two rows only the pieces with the rows are taken."""
    n_silent = 5_000_000 // len(silent)
    found = list(lines(b"1,2,3\n" + silent * n_silent + b"4,5,6\n", A_ROW))
    assert len(found) < n_silent / 5
    assert (found[0], found[-1]) == ((1, "1,2,3"), (n_silent + 2, "4,5,6"))
    assert all(one < other for (one, _), (other, _) in pairwise(found))


GAP = b"\n" * 600_000 + b"# nothing\n" * 60_000
FAR_APART = {
    "csv": GAP[:700_000] + b"1,2,3\n" + GAP + b"4,5,6\n" + GAP + b"7,8,10\n" + GAP,
    "obj": b"o part\n" + b"v 1 2 3\n" + GAP + b"v 4 5 6\n" + GAP + b"v 7 8 10\n" + GAP,
    "stl": b"solid part\nfacet normal 0 0 1\nouter loop\nvertex 1 2 3\n" + GAP
           + b"VERTEX 4 5 6\n" + GAP + b"  Vertex 7 8 10\nendloop\nendfacet\n" + GAP + b"endsolid part\n",
}  # fmt: skip


@pytest.mark.parametrize("text", FAR_APART.values(), ids=FAR_APART)
def test_rows_far_apart_are_all_read(text: bytes) -> None:
    np.testing.assert_array_equal(read(text).points, [[1, 2, 3], [4, 5, 6], [7, 8, 10]])


def test_a_word_far_down_is_named_by_its_line() -> None:
    with pytest.raises(ValueError, match="1 rows are not 3 numbers") as caught:
        read(b"1,2,3\n" + GAP + b"4,x,6\n")
    assert caught.value.field == "line 660002, column 2"
