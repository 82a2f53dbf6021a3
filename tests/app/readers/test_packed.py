"""gzip and zstd as other programs write them, in one piece or several."""

import gzip
import io
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard

from primfit.app.readers import Limits, TooLargeError, UnreadableFileError, read, unpack
from tests.paths import EXAMPLES

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
POINTS = np.random.default_rng(2).normal(size=(3000, 3)) * 100.0 + [1e6, -2e6, 3.0]
SKIPPABLE = b"\x53\x2a\x4d\x18\x04\0\0\0abcd"


def _npy(points: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, points)
    return stream.getvalue()


def _by_command(*command: str) -> Callable[[bytes], bytes]:
    def pack(data: bytes) -> bytes:
        if shutil.which(command[0]) is None:
            pytest.skip(f"needs {command[0]}")
        return subprocess.run(command, input=data, capture_output=True, check=True).stdout

    return pack


PACK: dict[str, Callable[[bytes], bytes]] = {
    "gzip": gzip.compress,
    "gzip of two members": lambda data: gzip.compress(data[:5000]) + gzip.compress(data[5000:]),
    "gzip with an empty member": lambda data: gzip.compress(b"") + gzip.compress(data),
    "gzip command": _by_command("gzip", "-9", "-c"),
    "zstd": zstandard.compress,
    "zstd of two frames": lambda data: zstandard.compress(data[:5000]) + zstandard.compress(data[5000:]),
    "zstd with a frame to skip": lambda data: zstandard.compress(data) + SKIPPABLE,
    "zstd without a size": zstandard.ZstdCompressor(write_content_size=False).compress,
    "zstd with a checksum": zstandard.ZstdCompressor(level=19, write_checksum=True).compress,
    "zstd command": _by_command("zstd", "-19", "-c"),
}


@pytest.mark.parametrize("pack", PACK.values(), ids=PACK)
def test_a_packed_file_gives_the_same_cloud(pack: Callable[[bytes], bytes]) -> None:
    cloud = read(pack(CSV))
    np.testing.assert_array_equal(cloud.points, read(CSV).points)
    assert cloud.format == "text"
    np.testing.assert_array_equal(read(pack(_npy(POINTS))).points, POINTS)


@pytest.mark.parametrize("pack", PACK.values(), ids=PACK)
def test_the_limit_counts_every_byte(pack: Callable[[bytes], bytes]) -> None:
    packed = pack(CSV)
    assert len(read(packed, Limits(unpacked_bytes=len(CSV))).points) == 300
    with pytest.raises(TooLargeError, match=f"more than {len(CSV) - 1} bytes"):
        read(packed, Limits(unpacked_bytes=len(CSV) - 1))


@pytest.mark.parametrize("pack", PACK.values(), ids=PACK)
def test_a_file_that_ends_early_is_refused_wherever_it_is_cut(pack: Callable[[bytes], bytes]) -> None:
    packed = pack(CSV[: CSV.rindex(b"\n", 0, 300)])
    whole = 0
    for end in range(4, len(packed)):
        try:
            read(packed[:end])
            whole += 1  # it ends between two frames
        except UnreadableFileError as error:
            assert error.field == "file"
    assert whole <= 1


def test_a_window_of_8_mib_is_read_and_a_larger_one_is_not() -> None:
    data = CSV * 1500  # 24 MB
    for window_log, read_it in ((23, True), (24, False)):
        parameters = zstandard.ZstdCompressionParameters(window_log=window_log, write_content_size=False)
        packed = zstandard.ZstdCompressor(compression_params=parameters).compress(data)
        if read_it:
            assert unpack(memoryview(packed), "zstd", Limits()) == data
        else:
            with pytest.raises(UnreadableFileError, match="8 MiB"):
                unpack(memoryview(packed), "zstd", Limits())


def test_the_command_line_reads_packed_files(tmp_path: Path) -> None:
    from primfit.app.cli.files import answer_file
    from primfit.app.cli.plan import plan

    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(CSV))
    (tmp_path / "b.npy.zst").write_bytes(zstandard.compress(_npy(POINTS)))
    (tmp_path / "notes.gz").write_bytes(gzip.compress(b"no cloud"))
    targets = plan([str(tmp_path)], tmp_path / "out", "json").targets
    assert sorted(path.name for path in targets) == ["a.json", "b.json"]
    assert answer_file(str(tmp_path / "a.csv.gz"), {}) == answer_file(str(EXAMPLES / "cylinder.csv"), {})
