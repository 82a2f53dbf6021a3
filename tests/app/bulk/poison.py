"""A segment that ends the process which reads it: a pipe at whose other end somebody kills the reader."""

import os
import signal
import time
from pathlib import Path
from threading import Thread


class Poison(Thread):
    """Kills whoever reads the file, so many times; later readers find the content in it.

    Attributes
    ----------
    killed : numbers of the processes, in the order in which they were killed
    """

    def __init__(self, file: Path, times: int, content: bytes = b"") -> None:
        super().__init__(daemon=True)
        os.mkfifo(file)
        self._file, self._times, self._content = file, times, content
        self.killed: list[int] = []

    def run(self) -> None:
        for left in reversed(range(self._times)):
            pipe = os.open(self._file, os.O_WRONLY)  # waits for a reader
            process = self._reader()
            self._renew(left)
            os.kill(process, signal.SIGKILL)
            self.killed.append(process)
            while lives(process):  # its end of the pipe is open until then
                time.sleep(0.01)
            os.close(pipe)

    def _renew(self, left: int) -> None:
        """What the next reader finds is another file, which the one that is killed has nothing to do with."""
        other = self._file.with_suffix(".next")
        if left:
            os.mkfifo(other)
        else:
            other.write_bytes(self._content)
        os.replace(other, self._file)

    def _reader(self) -> int:
        while True:
            for process in Path("/proc").glob("[0-9]*"):
                if int(process.name) != os.getpid() and self._reads(int(process.name)):
                    return int(process.name)
            time.sleep(0.01)

    def _reads(self, process: int) -> bool:
        try:
            return str(self._file) in map(os.readlink, Path(f"/proc/{process}/fd").iterdir())
        except OSError:  # it ended meanwhile, or closed something
            return False


def lives(process: int) -> bool:
    """Whether a process is there, and is no zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
