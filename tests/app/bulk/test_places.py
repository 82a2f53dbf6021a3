"""Files here and objects in a store that runs here, which throttles, answers 503, and loses connections."""

import errno
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from primfit.app.bulk import places
from primfit.app.bulk.refs import Ref, cloud_at
from primfit.app.bulk.sources import references
from primfit.app.engine.cut import cut
from primfit.app.readers import Pick, read
from tests.app.bulk.buckets import FAULTS, Faults, bucket_server
from tests.app.bulk.test_sources import INTEGERS, labelled_las

RNG = np.random.default_rng(13)
BUCKET = "s3://plant"


@pytest.fixture(scope="session")
def server() -> Iterator[tuple[str, Faults]]:
    """A server of S3 for all tests."""
    for name in ("moto.server", "s3fs", "aiohttp"):
        pytest.importorskip(name, reason="moto and the extra remote are missing")
    with bucket_server() as started:
        yield started


@pytest.fixture
def store(server: tuple[str, Faults], monkeypatch: pytest.MonkeyPatch) -> Iterator[Faults]:
    """An empty bucket `plant`; no client tries again by itself more than it must, and pauses are short."""
    import s3fs

    address, faults = server
    faults.begin((), 0)
    for name, value in {
        "AWS_ENDPOINT_URL": address, "AWS_ACCESS_KEY_ID": "key", "AWS_SECRET_ACCESS_KEY": "secret",
        "AWS_DEFAULT_REGION": "us-east-1", "AWS_MAX_ATTEMPTS": "1",
    }.items():  # fmt: skip
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(places, "PAUSES", (0.01,) * 7)
    places._files.cache_clear()
    s3fs.S3FileSystem.clear_instance_cache()
    files = places._files("s3")
    files.retries = 1
    if files.exists("plant"):
        files.rm("plant", recursive=True)
    files.mkdir("plant")
    yield faults
    places._files.cache_clear()


def test_files_here(tmp_path: Path) -> None:
    place = str(tmp_path / "new" / "a.bin")
    assert not places.exists(place)
    places.write_whole(place, b"0123456789")
    assert (places.read_bytes(place), places.read_range(place, 3, 4), places.size(place)) == (
        b"0123456789", b"3456", 10,
    )  # fmt: skip
    places.write_whole(place, b"other")
    assert list(places.names(str(tmp_path))) == [("new", True, None)]
    assert list(places.names(str(tmp_path / "new"))) == [("a.bin", False, 5)]
    assert (places.is_folder(str(tmp_path)), places.is_folder(place)) == (True, False)
    with pytest.raises(OSError, match=r"a\.bin"):
        places.read_range(place, 3, 4)
    with pytest.raises(FileNotFoundError, match="none"):
        places.size(str(tmp_path / "none"))


def test_what_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    with pytest.raises(OSError, match="taken"):
        places.write_whole(str(tmp_path / "taken"), b"x")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def use_all(folder: str, data: bytes) -> None:
    """Each of the functions of places, on two objects."""
    place = places.joined(folder, "a b#.bin")
    places.write_whole(place, data)
    places.write_whole(places.joined(folder, "in/c.bin"), b"x")
    assert places.read_bytes(place) == data
    assert places.read_range(place, 1000, 500) == data[1000:1500]
    assert places.read_range(place, 1000, 0) == b""
    assert places.size(place) == len(data)
    assert list(places.names(folder)) == [("a b#.bin", False, len(data)), ("in", True, 0)]
    assert [places.exists(place), places.exists(place + "x"), places.is_folder(folder)] == [True, False, True]
    with places.opened(place) as file:
        file.seek(-1000, 2)
        assert file.read() == data[-1000:]
    with pytest.raises(FileNotFoundError) as error:
        places.read_bytes(place + "x")
    assert error.value.filename == place + "x"


@pytest.mark.parametrize("kinds", [(), *[(kind,) for kind in FAULTS], FAULTS])
def test_a_bucket(store: Faults, kinds: tuple[str, ...]) -> None:
    store.begin(kinds, 3)
    use_all(f"{BUCKET}/folder", RNG.bytes(50_000))
    assert all(store.counts[kind] for kind in kinds)


def test_a_fault_that_outlasts_the_client_passes(store: Faults) -> None:
    places.write_whole(f"{BUCKET}/a", b"data")
    places._files("s3").retries = 5
    store.begin(("slow down", "dropped"), 12)
    assert places.read_bytes(f"{BUCKET}/a") == b"data"
    assert store.counts.total() >= 12


def test_a_fault_that_stays_is_told_with_its_place(store: Faults) -> None:
    store.begin(("503",), 1000)
    with pytest.raises(OSError, match="asked 8 times") as error:
        places.write_whole(f"{BUCKET}/a", b"data")
    assert error.value.filename == f"{BUCKET}/a"
    assert store.counts.total() >= 8
    with pytest.raises(OSError, match="asked 8 times"):
        places.exists(f"{BUCKET}/a")


def test_what_cannot_pass_is_not_tried_again(store: Faults) -> None:
    with pytest.raises(FileNotFoundError):
        places.write_whole("s3://none/a", b"data")
    with pytest.raises(OSError) as error:
        places.read_bytes("nosuch://a/b")
    assert "nosuch" in str(error.value)
    assert error.value.errno == errno.EIO


def test_a_copy_comes_by_pieces(store: Faults, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(places, "_PIECE", 10_000)
    data = RNG.bytes(45_001)
    (tmp_path / "a").write_bytes(data)
    places.put(tmp_path / "a", f"{BUCKET}/a")
    store.begin(FAULTS, 2)
    places.fetch(f"{BUCKET}/a", tmp_path / "b")
    assert (tmp_path / "b").read_bytes() == data
    assert store.counts.total() >= 10


def found(*inputs: str, labels: str | None = None, scratch: str = f"{BUCKET}/scratch") -> list[Ref]:
    return list(references(inputs, labels, None, scratch))


def put_clouds(*names: str) -> dict[str, bytes]:
    clouds = {
        f"{BUCKET}/{name}": "".join(f"{x},{y},{z}\n" for x, y, z in RNG.random((9, 3))).encode()
        for name in names
    }
    for place, data in clouds.items():
        places.write_whole(place, data)
    return clouds


def test_folders_globs_and_lists_of_a_bucket(store: Faults) -> None:
    clouds = put_clouds("s/a.csv", "s/b.xyz", "s/in/c.csv", "s/in/d.csv", "s/notes.md")
    names = list(clouds)
    places.write_whole(f"{BUCKET}/list.txt", "\n".join(names[1::-1]).encode())
    store.begin(FAULTS, 2)
    assert [ref.id for ref in found(f"{BUCKET}/s")] == names[:4]
    assert [ref.id for ref in found(f"{BUCKET}/s/**/*.csv")] == [names[0], *names[2:4]]
    assert [ref.id for ref in found(f"@{BUCKET}/list.txt")] == names[1::-1]
    for ref in found(BUCKET):
        assert ref.file in clouds or ref.file.endswith("list.txt")
    for ref in found(f"{BUCKET}/s/"):
        cloud, _ = cloud_at(ref, {})
        assert cloud == read(clouds[ref.file])
    assert store.counts.total() > 20


@pytest.mark.parametrize("remote", [False, True])
def test_a_scan_in_a_bucket(store: Faults, tmp_path: Path, remote: bool) -> None:
    data = labelled_las(tmp_path / "scan.laz", INTEGERS).read_bytes()
    places.write_whole(f"{BUCKET}/scan.laz", data)
    store.begin(FAULTS, 1)
    scratch = f"{BUCKET}/scratch" if remote else str(tmp_path / "scratch")
    refs = found(f"{BUCKET}/scan.laz", labels="auto", scratch=scratch)
    expected = list(cut(read(data, pick=Pick("auto"))))
    assert [ref.id for ref in refs] == [f"{BUCKET}/scan.laz#{label}" for label, _, _ in expected]
    for ref, (_, _, segment) in zip(refs, expected, strict=True):
        assert cloud_at(ref, {})[0] == segment
    assert found(f"{BUCKET}/scan.laz", labels="auto", scratch=scratch) == refs


def test_parquet_in_a_bucket(store: Faults, tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow", reason="pyarrow comes with the extra bulk")
    pq = pytest.importorskip("pyarrow.parquet", reason="pyarrow comes with the extra bulk")
    clouds = [RNG.normal(size=(n, 3)) for n in range(300)]
    table: dict[str, Any] = {"id": list(range(300)), "points": [cloud.tolist() for cloud in clouds]}
    pq.write_table(pa.table(table), str(tmp_path / "s.parquet"), row_group_size=50)
    places.put(tmp_path / "s.parquet", f"{BUCKET}/s.parquet")
    put_clouds("s/a.csv")
    pq.write_table(pa.table({"path": ["s/a.csv"]}), str(tmp_path / "r.parquet"))
    places.put(tmp_path / "r.parquet", f"{BUCKET}/r.parquet")
    store.begin(FAULTS, 2)
    for ref, points in zip(found(f"{BUCKET}/s.parquet"), clouds, strict=True):
        assert cloud_at(ref, {})[0].points.tobytes() == points.tobytes()
    (ref,) = found(f"{BUCKET}/r.parquet")
    assert (ref.id, ref.store) == (f"{BUCKET}/r.parquet#s/a.csv", f"{BUCKET}/s/a.csv")
    assert len(cloud_at(ref, {})[0].points) == 9


def test_http(store: Faults, server: tuple[str, Faults]) -> None:
    ((place, data),) = put_clouds("s/a.csv").items()
    address = f"{server[0]}/{place.removeprefix('s3://')}"
    with pytest.raises(PermissionError):
        places.read_bytes(address)
    places._files("s3").chmod(place, "public-read")
    store.begin(FAULTS, 4)
    (ref,) = found(address)
    assert (ref.id, ref.store) == (address.replace("%", "%25"), None)
    assert cloud_at(ref, {})[0] == read(data)
    assert places.size(address) == len(data)
    assert places.read_range(address, 5, 20) == data[5:25]
    with pytest.raises(FileNotFoundError):
        places.read_bytes(address + "x")
    assert store.counts.total() >= 12
