"""What `palpate frames` is asked, and the recording that it is asked about.

Apart from what perceives, so that a file that cannot be read is refused before the mathematics is loaded.
"""

from dataclasses import dataclass
from pathlib import Path

from exploration.recordings.open import open_recording
from exploration.recordings.recording import Recording
from exploration.sensing.spec import load_sensor
from primitives.errors import PalpateError


@dataclass(frozen=True)
class FramesOptions:
    """What was asked."""

    file: str
    sensor: str | None = None  # preset or TOML file; None: as the recording says
    index: int | None = None  # one frame instead of all
    png: Path | None = None  # folder for pictures

    def recording(self) -> Recording:
        """The recording, opened; what is wrong with file, sensor or folder is said here."""
        spec = load_sensor(self.sensor) if self.sensor else None
        recording = open_recording(Path(self.file), spec)
        if self.index is not None and self.index < 0:
            raise PalpateError(f"--index {self.index}: frames are counted from 0")
        return recording

    def folder(self) -> Path | None:
        """The folder for pictures, new or empty."""
        path = self.png
        if path is None:
            return None
        try:
            path.mkdir(parents=True, exist_ok=True)
            if any(path.iterdir()):
                raise PalpateError(f"--png {path} is not empty; name a new folder")
        except (FileExistsError, NotADirectoryError):
            raise PalpateError(f"--png {path} is a file, or in one; name a folder") from None
        except OSError as error:
            raise PalpateError(
                f"cannot write to --png {path} ({error.strerror or error}); choose another"
            ) from error
        return path
