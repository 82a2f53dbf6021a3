"""Names from outside are made harmless, and ids differ."""

import pytest

from primfit.app.engine.names import Ids, base_name, plain


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("scan.csv", "scan.csv"),
        ("größe 部品.ply", "größe 部品.ply"),
        ("../../etc/passwd", "passwd"),
        ("C:\\scans\\part.ply", "part.ply"),
        ("a\0b\x1b[2J\u202egpj.csv", "a_b_[2J_gpj.csv"),
        ("n" * 300 + ".csv", "n" * 80),
        ("..", None),
        (" . ", None),
        ("dir/", None),
        ("", None),
        (None, None),
    ],
)
def test_the_last_component_is_left_and_printable(name: str | None, shown: str | None) -> None:
    assert base_name(name) == shown


def test_what_systems_do_not_allow_in_names_is_replaced() -> None:
    assert plain('a/b\\c:d*e?f"g<h>i|j') == "a_b_c_d_e_f_g_h_i_j"


def test_ids_differ_also_without_their_capitals() -> None:
    ids = Ids()
    given = [ids.of_file(name, i) for i, name in enumerate(("a.csv", "A.csv", "a.csv", "a.csv~2", None), 1)]
    assert given == ["a.csv", "A.csv~2", "a.csv~3", "a.csv~2~2", "file-5"]
    segments = [ids.of_segment("a.csv", label) for label in (-1, "x/y", "x_y", "x" * 99, "x" * 100)]
    assert segments == [
        "a.csv#-1",
        "a.csv#x_y",
        "a.csv#x_y~2",
        "a.csv#" + "x" * 22,
        "a.csv#" + "x" * 22 + "~2",
    ]


def test_ids_stay_short_and_quick_however_often_a_name_comes() -> None:
    ids = Ids()
    given = {ids.of_segment(ids.of_file("n" * 80, i), "l" * 80) for i in range(10_000)}
    assert len(given) == 10_000
    assert max(map(len, given)) <= 80
