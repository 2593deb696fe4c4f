"""Open any recording: the reader for a file's suffix."""

from collections.abc import Callable
from pathlib import Path

from exploration.recordings.csv_stack import read_csv
from exploration.recordings.dsa import read_dsa
from exploration.recordings.episode import read_episode
from exploration.recordings.flexitac_log import read_flexitac
from exploration.recordings.intake import opened, refuse_other_content
from exploration.recordings.numpy_stack import read_npy, read_npz
from exploration.recordings.recording import Recording
from exploration.sensing.spec import SensorSpec
from primitives.errors import PalpateError

READERS: dict[str, Callable[[Path, SensorSpec | None], Recording]] = {
    ".mcap": read_episode,
    ".dsa": read_dsa,
    ".csv": read_csv,
    ".npy": read_npy,
    ".npz": read_npz,
    ".bin": read_flexitac,
}


def open_recording(path: Path, spec: SensorSpec | None = None) -> Recording:
    """The frames of a file; `spec` says which array they came from where the file does not."""
    suffix = path.suffix.lower()
    if suffix not in READERS:
        with opened(path):
            pass
        raise PalpateError(f"{path} is no recording; give a file that ends in {', '.join(READERS)}")
    refuse_other_content(path, suffix)
    return READERS[suffix](path, spec)
