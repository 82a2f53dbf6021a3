"""Bytes that are there, in memory or in a file of which only what is looked at is read."""

from typing import BinaryIO, Protocol


class Stretch(Protocol):
    """So many bytes, of which slices may be had: a `memoryview`, or `FileBytes`."""

    def __len__(self) -> int: ...

    def __getitem__(self, part: slice, /) -> memoryview: ...


class FileBytes:
    """The bytes of an open file; a slice of them is read when it is asked for."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._size = file.seek(0, 2)

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, part: slice, /) -> memoryview:
        start, stop, _ = part.indices(self._size)
        self._file.seek(start)
        return memoryview(self._file.read(max(0, stop - start)))
