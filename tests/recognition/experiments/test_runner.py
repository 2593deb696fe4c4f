"""Suites run: the same table whatever the workers, each row once, and every end a row."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from primitives.errors import PalpateError
from recognition.experiments.carried import carried
from recognition.experiments.crew import Worker
from recognition.experiments.folder import SuiteFolder
from recognition.experiments.kinds import KINDS
from recognition.experiments.log import Log, rows_of
from recognition.experiments.runner import ExperimentOptions, parse_shard, run
from recognition.experiments.suite import Limits, load_suite

SUITE = """
name = "little"
[[trials]]
kind = "frames"
scene = ["edge", "flat"]
noise = 0.05
count = 2
seeds = 2
[[trials]]
kind = "track"
part = "broken.stl"
"""


@pytest.fixture
def suite(tmp_path):
    path = tmp_path / "little.toml"
    (tmp_path / "broken.stl").write_text("no triangles")
    path.write_text(SUITE)
    return path


def table(folder):
    told = pq.read_table(Path(folder) / "results.parquet")
    return told.select([name for name in told.column_names if not name.endswith("_seconds")])


def test_shards_in_one_folder_make_the_table_of_one_process(suite, tmp_path):
    summary, _ = run(ExperimentOptions(suite, tmp_path / "one", workers=0))
    assert summary["outcomes"] == {"done": 4, "failed": 1}
    for shard in ("0/2", "1/2"):
        run(ExperimentOptions(suite, tmp_path / "two", workers=0, shard=parse_shard(shard)))
    assert table(tmp_path / "one").equals(table(tmp_path / "two"))
    assert "report.html" in {path.name for path in (tmp_path / "two").iterdir()}


@pytest.mark.slow
def test_workers_make_the_table_of_one_process(suite, tmp_path):
    run(ExperimentOptions(suite, tmp_path / "one", workers=0))
    run(ExperimentOptions(suite, tmp_path / "crew", workers=2))
    assert table(tmp_path / "one").equals(table(tmp_path / "crew"))


def test_resuming_repeats_nothing_and_mends_a_torn_line(suite, tmp_path):
    out = tmp_path / "out"
    run(ExperimentOptions(suite, out, workers=0))
    whole, log = table(out), out / "trials.jsonl"
    lines = log.read_bytes().splitlines(keepends=True)
    kept = lines[:2]
    log.write_bytes(b"".join(kept) + lines[2][:20])
    run(ExperimentOptions(suite, out, workers=0, resume=True))
    assert log.read_bytes().splitlines(keepends=True)[:2] == kept
    numbers = [json.loads(line)["trial"] for line in log.read_text().splitlines()]
    assert sorted(numbers) == [0, 1, 2, 3, 4]
    assert table(out).equals(whole)


def test_another_suite_does_not_go_into_the_folder(suite, tmp_path):
    out = tmp_path / "out"
    run(ExperimentOptions(suite, out, workers=0))
    with pytest.raises(PalpateError, match="--resume"):
        run(ExperimentOptions(suite, out, workers=0))
    suite.write_text(SUITE.replace("seeds = 2", "seeds = 3"))
    with pytest.raises(PalpateError, match="another suite"):
        run(ExperimentOptions(suite, out, workers=0, resume=True))


def test_a_trial_that_hangs_or_grows_is_a_row_with_its_reason(suite, tmp_path, monkeypatch):
    trial = load_suite(suite).trials[0]
    ends = {
        "timeout": lambda self, s, w: [None for _ in iter(int, 1)],
        "memory": lambda self, s, w: bytearray(10**9),
    }
    for outcome, carry in ends.items():
        monkeypatch.setattr(type(KINDS["frames"]), "carry", carry)
        row = carried(trial, tmp_path / "scratch", Limits(0.2, 200.0))
        assert row["outcome"] == outcome
        assert "[limits]" in row["reason"]
    assert not (tmp_path / "scratch").exists()


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_its_trial_alone(suite, tmp_path):
    trial = load_suite(suite).trials[0]
    worker = Worker(("frames",), Limits(60.0, 4000.0), tmp_path / "scratch")
    try:
        process = worker._running()
        process.kill()
        process.wait()
        assert worker.carry(trial, None)["outcome"] == "done"
    finally:
        worker.end()


def test_a_log_that_cannot_be_written_says_how_to_go_on():
    if not Path("/dev/full").exists():
        pytest.skip("left out: no /dev/full here")
    log = Log.__new__(Log)
    import os

    log._path, log._file = Path("trials.jsonl"), os.open("/dev/full", os.O_WRONLY)
    with pytest.raises(PalpateError, match="--resume"):
        log.append({"trial": 1})


def test_rows_told_twice_count_once(tmp_path):
    for name in ("trials.jsonl", "trials-1-of-2.jsonl"):
        with Log(tmp_path / name) as log:
            log.append({"trial": 3, "outcome": "done"})
    assert list(rows_of([tmp_path])) == [3]


def test_rows_of_another_suite_or_of_none_are_not_merged(suite, tmp_path):
    other = tmp_path / "other.toml"
    other.write_text(SUITE.replace("seeds = 2", "seeds = 1"))
    run(ExperimentOptions(other, tmp_path / "other", workers=0))
    for wrong, said in (("other", "another suite"), ("missing", "is no folder"), ("", "holds no suite")):
        with pytest.raises(PalpateError, match=said) as error:
            run(ExperimentOptions(suite, tmp_path / "out", workers=0, merge=(tmp_path / wrong,)))
        assert "\n" not in str(error.value)
    assert not (tmp_path / "out").exists()


def test_folders_of_shards_are_merged_into_the_table_of_all(suite, tmp_path):
    run(ExperimentOptions(suite, tmp_path / "one", workers=0, shard=(1, 2)))
    told, _ = run(
        ExperimentOptions(suite, tmp_path / "two", workers=0, shard=(2, 2), merge=(tmp_path / "one",))
    )
    assert told["complete"]


@pytest.mark.parametrize("also", [{"resume": True}, {"shard": (1, 2)}])
def test_overwriting_goes_with_nothing_that_keeps_rows(suite, also):
    with pytest.raises(PalpateError, match="--overwrite"):
        ExperimentOptions(suite, overwrite=True, **also)


def test_a_scheduler_that_does_not_answer_leaves_no_folder(suite, tmp_path, monkeypatch):
    cluster = pytest.importorskip("recognition.experiments.cluster")
    pytest.importorskip("distributed", reason="left out: dask is not installed (palpate[cluster])")
    monkeypatch.setattr(cluster, "_WAIT", 0.2)
    with pytest.raises(PalpateError, match="no dask scheduler answers") as error:
        run(ExperimentOptions(suite, tmp_path / "out", scheduler="tcp://127.0.0.1:9"))
    assert "\n" not in str(error.value)
    assert not (tmp_path / "out").exists()


def test_a_folder_without_rows_is_as_good_as_new(suite, tmp_path):
    SuiteFolder.of(load_suite(suite), tmp_path / "out", False, False, False)
    told, _ = run(ExperimentOptions(suite, tmp_path / "out", workers=0))
    assert told["complete"]


@pytest.mark.parametrize("text", ["5/4", "1", "a/b", "1/0", "-1/2"])
def test_a_shard_that_is_none_is_refused(text):
    with pytest.raises(PalpateError, match="i/N"):
        parse_shard(text)
