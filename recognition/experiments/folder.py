"""A suite on disk: its own text, the rows as they come, and the results when they are written."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from primitives.errors import NotWritten, PalpateError
from recognition.experiments.suite import Suite
from recognition.running.folder import RunFolder

MARK = "suite.json"
OWN = (MARK, "suite.toml", "results.parquet", "summary.json", "report.html", ".lock", "runs")


@dataclass(frozen=True)
class SuiteFolder(RunFolder):
    """Where one suite goes."""

    @staticmethod
    def of(suite: Suite, out: Path | None, resume: bool, overwrite: bool, shared: bool) -> SuiteFolder:
        """A new folder, or that of the same suite where it is gone on with, or `shared` among shards.

        A folder of the same suite that holds no row yet is as good as new.
        """
        path = out if out is not None else Path("runs") / suite.name
        try:
            path.mkdir(parents=True, exist_ok=True)
            present = sorted(entry.name for entry in path.iterdir())
        except FileExistsError as error:
            raise PalpateError(f"--out {path} is a file; give a folder") from error
        except OSError as error:
            raise NotWritten(
                f"cannot write to --out {path} ({error.strerror or error}); choose another folder"
            ) from error
        folder = SuiteFolder(path)
        if present and MARK not in present:
            raise PalpateError(f"--out {path} is not empty and holds no suite; give a new or empty folder")
        if present and overwrite:
            folder._clear(present)
        elif present:
            folder._require_same(suite)
            if not (resume or shared) and folder._begun(present):
                raise PalpateError(
                    f"--out {path} already holds this suite; add --resume to go on, or --overwrite to begin anew"
                )
        if not (path / MARK).exists():
            folder.write_text("suite.toml", suite.source)
            folder.write_json(MARK, {"suite": suite.name, "fingerprint": suite.fingerprint})
        return folder

    @staticmethod
    def merged(suite: Suite, path: Path) -> SuiteFolder:
        """The folder of other shards, which must be of the same suite."""
        folder = SuiteFolder(path)
        if not (path / MARK).is_file():
            what = "holds no suite" if path.is_dir() else "is no folder"
            raise PalpateError(f"--merge {path} {what}; give the --out of another shard of this suite")
        folder._require_same(suite, "--merge", "give the --out of another shard of this suite")
        return folder

    def _require_same(
        self, suite: Suite, flag: str = "--out", fix: str = "give a new folder, or --overwrite"
    ) -> None:
        try:
            told = json.loads((self.path / MARK).read_text(encoding="utf-8"))["fingerprint"]
        except (OSError, ValueError, KeyError, TypeError):
            told = ""
        if told != suite.fingerprint:
            raise PalpateError(
                f"{flag} {self.path} holds another suite, or this one before it was changed; {fix}"
            )

    def _begun(self, present: list[str]) -> bool:
        """Whether there is a row, or a result."""
        logs = [self.path / name for name in present if name.startswith("trials")]
        return "summary.json" in present or any(log.stat().st_size for log in logs)

    def _clear(self, present: list[str]) -> None:
        import shutil

        strangers = [n for n in present if n not in OWN and not n.startswith("trials")]
        if strangers:
            raise PalpateError(
                f"--out {self.path} holds {strangers[0]}, which is no part of a suite; give a new or empty folder"
            )
        for name in present:
            if name == "runs":
                shutil.rmtree(self.path / name)
            else:
                (self.path / name).unlink()

    @contextmanager
    def locked(self) -> Iterator[None]:
        """One at a time among shards that write results here."""
        try:
            import fcntl
        except ImportError:
            yield
            return
        with (self.path / ".lock").open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield
