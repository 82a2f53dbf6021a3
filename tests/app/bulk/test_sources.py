"""Which segments inputs hold, and that each of them is what the commands without references see."""

import os
import tracemalloc
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import orjson
import pytest

from primfit.app.bulk import grouping
from primfit.app.bulk.refs import Ref, cloud_at
from primfit.app.bulk.repeated import repeated
from primfit.app.bulk.sources import GivenTwiceError, references, stands_on
from primfit.app.engine.cut import cut
from primfit.app.readers import Cloud, Pick, UnreadableFileError, read_file

RNG = np.random.default_rng(5)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, which names are relative to."""
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def write(*names: str) -> None:
    for name in names:
        path = Path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(f"{x},{y},{z}\n" for x, y, z in RNG.random((9, 3)).tolist()))


def found(*inputs: str, labels: str | None = None, **others: Any) -> list[Ref]:
    return list(references(inputs, labels, None, "../scratch", **others))


def ids(*inputs: str) -> list[str]:
    return [ref.id for ref in found(*inputs)]


def test_folders_are_searched_inwards_by_name(here: Path) -> None:
    write("scans/b.csv", "scans/a.xyz", "scans/a/2.ply", "scans/a/1/deep.csv.gz", "scans/a.txt/x.npy")
    write("scans/notes.md", "scans/README", "scans/a_prediction.txt", "scans/old.md")
    others: Counter[str] = Counter()
    suffixes = (".csv", ".xyz", ".ply", ".gz", ".npy")
    expected = [path.as_posix() for path in sorted(Path("scans").rglob("*")) if path.suffix in suffixes]
    refs = found("scans", others=others)
    assert [ref.id for ref in refs] == [ref.file for ref in refs] == expected
    assert others == {".md": 2, "without suffix": 1}
    assert ids("./scans/") == ids("scans")
    os.chdir("scans")
    assert ids(".") == [ref.id.removeprefix("scans/") for ref in refs]


def test_a_link_to_a_folder_is_not_followed(here: Path) -> None:
    write("scans/a.csv")
    os.symlink("..", "scans/up")
    assert ids("scans") == ids("scans/**/*.csv") == ["scans/a.csv"]


def test_what_is_reached_through_a_link_is_not_left_out(here: Path) -> None:
    write("scans/a.csv", "real/b.csv")
    os.symlink("../real", "scans/two")
    both = ["scans/a.csv", "scans/two/b.csv"]
    assert ids("scans", "scans/two") == ids("scans", "scans/two/b.csv") == both
    assert ids("scans/**/*.csv", "scans/two/b.csv") == both
    assert ids("scans/*/*.csv") == both[1:] == ids("scans/*/*.csv", "scans/two/b.csv")


def test_answers_of_a_run_are_no_inputs(here: Path) -> None:
    write("scans/a.csv", "scans/answers/part-000000.parquet", "scans/answers/_primfit/manifest.json")
    assert ids("scans") == ["scans/a.csv"]


def test_relative_names_are_those_of_a_folder(here: Path) -> None:
    write("a.csv")
    Path("list.txt").write_text("a.csv\n")
    whole = str(here / "a.csv")
    assert stands_on([whole, "s3://bucket/a.csv"]) is None
    assert stands_on([whole, "a.csv"]) == stands_on([f"@{Path('list.txt').absolute()}"]) == os.getcwd()


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("s/*.csv", ["s/a.csv", "s/b.csv"]),
        ("s/*/*.csv", ["s/in/c.csv"]),
        ("s/**/*.csv", ["s/a.csv", "s/b.csv", "s/in/c.csv", "s/in/in/d.csv"]),
        ("s/[ab]*", ["s/a.csv", "s/a.odd", "s/b.csv"]),
        ("*/in/?.csv", ["s/in/c.csv"]),
        ("s/**/in/*", ["s/in/c.csv", "s/in/in/d.csv"]),
        ("nothing*", []),
    ],
)  # fmt: skip
def test_globs(here: Path, pattern: str, expected: list[str]) -> None:
    write("s/a.csv", "s/b.csv", "s/a.odd", "s/.hidden.csv", "s/in/c.csv", "s/in/in/d.csv")
    assert ids(pattern) == expected


def test_a_name_that_looks_like_a_glob_is_a_file_where_there_is_one(here: Path) -> None:
    write("a[1].csv", "a1.csv")
    assert ids("a[1].csv") == ["a[1].csv"]


def test_lists_hold_one_input_a_line(here: Path) -> None:
    write("one.csv", "two.csv", "more/x.csv", "more/y.csv")
    Path("list.txt").write_bytes(b"\xef\xbb\xbftwo.csv\r\n\r\n  more/*.csv\n")
    assert ids("one.csv", "@list.txt") == ["one.csv", "two.csv", "more/x.csv", "more/y.csv"]


def test_what_overlaps_is_there_once(here: Path) -> None:
    write("s/a.csv", "s/in/b.csv", "s/in/c.csv", "s/odd")
    assert ids("s/in", "s", str(here / "s"), "s/**/*.csv", "s/a.csv") == [
        "s/in/b.csv",
        "s/in/c.csv",
        "s/a.csv",
    ]
    assert ids("s/odd", "s/a.csv", "s/in/*") == ["s/odd", "s/a.csv", "s/in/b.csv", "s/in/c.csv"]


def test_a_file_that_is_named_twice_is_refused(here: Path) -> None:
    write("a.csv", "b.csv")
    Path("list.txt").write_text(f"b.csv\n./x/../a.csv\n{here / 'a.csv'}\n")
    with pytest.raises(GivenTwiceError, match=r"a\.csv is given twice"):
        found("@list.txt")


def test_a_value_that_stands_twice_is_found_in_any_round(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("primfit.app.bulk.repeated.HELD", 7)
    values = [str(i) for i in range(100)]
    assert repeated(lambda: values) is None
    for value in values:
        assert repeated([*values, value].copy) == value


def test_ids_of_files_and_segments_never_meet(here: Path) -> None:
    Path("a.csv").write_text("x,y,z,label\n" + "1,2,3,1\n" * 3)
    write("a.csv#1", "a.csv%231")
    told = [ref.id for ref in found("a.csv", "a.csv#1", "a.csv%231", labels="auto")]
    assert told == ["a.csv#1", "a.csv%231", "a.csv%25231"]


def test_a_whole_file_is_had_from_anywhere(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write("s/a.csv")
    (ref,) = found("s")
    monkeypatch.chdir("/")
    cloud, options = cloud_at(ref, {"seed": 3})
    assert cloud == read_file(here / "s" / "a.csv")
    assert options == {"seed": 3}
    assert ref.n_points == (here / "s" / "a.csv").stat().st_size // 40


def test_options_in_a_file_hold(here: Path) -> None:
    Path("a.json").write_text('{"points": [[1,2,3],[4,5,6],[7,8,10]], "options": {"seed": 9}}')
    (ref,) = found("a.json")
    assert cloud_at(ref, {"criterion": "huber"})[1]["seed"] == 9


def test_a_reference_comes_back_from_its_line(here: Path) -> None:
    for ref in (
        Ref("a", "a", None, 3),
        Ref("a#x", "a", "x", 3, "/s.segments", 5, 8),
        Ref("a", "a", None, 0, "/a", problem=("labels", "none", True)),
    ):
        assert Ref.from_plain(orjson.loads(orjson.dumps(ref.to_plain()))) == ref


def labelled_las(path: Path, labels: np.ndarray) -> Path:
    header = laspy.LasHeader(point_format=3)
    header.scales = np.full(3, 1e-4)
    header.add_extra_dim(laspy.ExtraBytesParams("label", labels.dtype))
    las = laspy.LasData(header)
    las.x, las.y, las.z = RNG.random((3, len(labels)))
    las.label = labels
    las.write(str(path))
    return path


def labelled_text(path: Path, labels: np.ndarray) -> Path:
    rows = (
        f"{x},{y},{z},{label}\n"
        for (x, y, z), label in zip(RNG.random((len(labels), 3)), labels, strict=True)
    )
    path.write_text("x,y,z,part\n" + "".join(rows))
    return path


INTEGERS = RNG.integers(-4, 30, 2000).astype(np.int32)
STRINGS = RNG.choice(np.array(["wall", "pipe 7", "10", "9"]), 2000)
SCANS = {
    "las": ("scan.las", labelled_las, INTEGERS, "auto"),
    "laz": ("scan.laz", labelled_las, INTEGERS, "label"),
    "text": ("scan.csv", labelled_text, INTEGERS, "part"),
    "strings": ("scan.txt", labelled_text, STRINGS, "part"),
}


@pytest.mark.parametrize("scan", SCANS.values(), ids=SCANS.keys())
def test_a_scan_gives_the_segments_of_the_whole_file(here: Path, scan: Any) -> None:
    name, make, labels, column = scan
    make(Path(name), labels)
    expected = list(cut(read_file(name, pick=Pick(column))))
    refs = found(name, labels=column)
    assert [ref.id for ref in refs] == [f"{name}#{label}" for label, _, _ in expected]
    assert [ref.n_points for ref in refs] == [len(rows) for _, rows, _ in expected]
    os.chdir("/")
    for ref, (_, _, segment) in zip(refs, expected, strict=True):
        cloud, _ = cloud_at(ref, {})
        assert cloud.points.tobytes() == segment.points.tobytes()
        assert cloud == segment


def test_what_stands_beside_the_points_comes_along(here: Path) -> None:
    labels = INTEGERS.tolist()
    told = {"points": RNG.random((2000, 3)).tolist(), "labels": labels, "weights": RNG.random(2000).tolist()}
    Path("a.json").write_bytes(orjson.dumps({**told, "options": {"seed": 9}}))
    np.savez("a.npz", points=RNG.random((2000, 3)), normals=RNG.normal(size=(2000, 3)), labels=INTEGERS)
    for name, beside, seed in (("a.json", "weights", 9), ("a.npz", "normals", None)):
        expected = [segment for _, _, segment in cut(read_file(name, pick=Pick("auto")))]
        answers = [cloud_at(ref, {"criterion": "huber"}) for ref in found(name, labels="auto")]
        assert [cloud for cloud, _ in answers] == expected
        assert getattr(expected[0], beside) is not None
        assert {options.get("seed") for _, options in answers} == {seed}


def test_a_scan_is_grouped_once_and_again_when_it_has_changed(here: Path) -> None:
    path = labelled_las(Path("scan.las"), INTEGERS)
    first = found("scan.las", labels="auto")
    (store,) = Path("../scratch").glob("*.segments")
    written = store.stat().st_mtime_ns
    assert found("scan.las", labels="auto") == first
    assert store.stat().st_mtime_ns == written
    labelled_las(path, INTEGERS[:1500])
    assert sum(ref.n_points for ref in found("scan.las", labels="auto")) == 1500


def test_a_grouping_that_was_broken_off_is_done_again(here: Path) -> None:
    labelled_las(Path("scan.las"), INTEGERS)
    first = found("scan.las", labels="auto")
    for head in Path("../scratch").glob("*.segments.json"):
        head.unlink()
    for store in Path("../scratch").glob("*.segments"):
        store.write_bytes(b"half")
    assert found("scan.las", labels="auto") == first
    assert len(cloud_at(first[0], {})[0].points) == first[0].n_points


def test_a_file_without_labels_is_one_cloud(here: Path) -> None:
    write("a.csv")
    (ref,) = found("a.csv", labels="auto")
    assert (ref.id, ref.label) == ("a.csv", None)
    assert cloud_at(ref, {})[0] == read_file("a.csv")


@pytest.mark.parametrize(
    ("name", "column", "field", "no_cloud"),
    [("scan.las", "wrong", "labels", False), ("broken.las", "auto", "header", False),
     ("none.las", "auto", "file", False), ("table.csv", "auto", "header", True)],
)  # fmt: skip
def test_what_is_wrong_with_a_file_is_said_by_its_reference(
    here: Path, name: str, column: str, field: str, no_cloud: bool
) -> None:
    labelled_las(Path("scan.las"), INTEGERS)
    Path("broken.las").write_bytes(b"LASF" + bytes(400))
    Path("table.csv").write_text("name,age\nAda,36\n")
    write("good.csv")
    (bad,), (good,) = found(name, labels=column), found("good.csv", labels="auto")
    assert bad.id == name
    with pytest.raises(UnreadableFileError) as error:
        cloud_at(bad, {})
    assert (error.value.field, error.value.no_cloud) == (field, no_cloud)
    assert len(cloud_at(good, {})[0].points) == 9


def test_references_come_before_all_are_known(here: Path) -> None:
    write("one.csv")
    Path("list.txt").write_text("one.csv\nnone/such.csv\n")
    stream = references(["@list.txt"], None, None, "../scratch")
    assert next(stream).id == "one.csv"
    missing = next(stream)
    with pytest.raises(UnreadableFileError, match="No such file"):
        cloud_at(missing, {})


def pieces_of(n_points: int, skewed: bool) -> Iterator[Cloud]:
    generator = np.random.default_rng(1)
    for _ in range(n_points // 20_000):
        labels = generator.integers(0, 3000, 20_000)
        if skewed:
            labels[generator.random(20_000) < 0.95] = 7
        yield Cloud(generator.random((20_000, 3)), ("x", "y", "z"), None, "las", labels=labels)


@pytest.mark.parametrize("skewed", [False, True])
def test_memory_does_not_grow_with_the_scan(
    skewed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(grouping, "PIECE", 20_000)
    peaks = []
    for n_points in (200_000, 2_000_000):
        store = tmp_path / f"{n_points}.segments"
        tracemalloc.start()
        grouping.group(pieces_of(n_points, skewed), store, 8)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert store.stat().st_size == 24 * n_points
    assert peaks[1] < 1.3 * peaks[0]
    assert peaks[1] < 6_000_000
