import base64
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from exploration.recordings.container import topics_at_end
from exploration.recordings.episode import read_episode
from exploration.recordings.mcap import RecordedEvent, RecordedFrame, Recorder, arrays, events, read
from exploration.sensing.frame import TaxelFrame
from primitives.errors import PalpateError
from primitives.pose import pose, random_rotation


def episode(count=300, whole=True):
    rng = np.random.default_rng(1)
    for i in range(count):
        counts = rng.normal(300, 40, (10, 16))
        frame = TaxelFrame(np.round(counts) if whole else counts, i / 200, i)
        yield frame, pose(random_rotation(rng), rng.uniform(-300, 300, 3)), rng.normal(size=6)


def record(path, count=300, whole=True):
    with Recorder(path) as recorder:
        recorder.pad("lts210", (28.8, 18.0), 0.0)
        for i, (frame, place, wrench) in enumerate(episode(count, whole)):
            if i % 50 == 0:
                recorder.event(i / 200, "touch", {"index": i // 50, "at": place[:3, 3]})
            recorder.frame("lts210", frame, place, wrench)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("mcap") / "episode.mcap"
    record(path)
    return path


def key(item):
    if isinstance(item, RecordedEvent):
        return item.kind, item.time, item.detail["index"]
    return item.sensor, item.frame.index, item.frame.counts.tobytes()


def test_what_is_recorded_reads_back_in_order(recorded):
    items = list(read(recorded))
    frames = [item for item in items if isinstance(item, RecordedFrame)]
    assert len(frames) == 300
    assert len(items) - len(frames) == 6
    for found, (frame, place, wrench) in zip(frames, episode(), strict=True):
        np.testing.assert_array_equal(found.frame.counts, frame.counts)
        assert found.frame.time == pytest.approx(frame.time, abs=1e-9)
        np.testing.assert_allclose(found.world_from_sensor, place, atol=1e-6)
        np.testing.assert_allclose(found.wrench, wrench, rtol=1e-8)
    assert items[0] == RecordedEvent(0.0, "touch", items[0].detail)
    assert items[0].detail["index"] == 0
    assert list(events(recorded)) == [item for item in items if isinstance(item, RecordedEvent)]


def test_an_array_that_is_turned_to_the_object_late_is_read_as_the_others_are(tmp_path):
    path = tmp_path / "two.mcap"
    with Recorder(path) as recorder:
        for i in range(320):
            name, shape = ("fingertip", (4, 4)) if i >= 300 else ("lts210", (10, 16))
            recorder.frame(name, TaxelFrame(np.full(shape, float(i)), i / 200, i), np.eye(4), np.zeros(6))
    assert arrays(path) == ("lts210", "fingertip")
    whole = path.read_bytes()
    with path.open("rb") as file:
        assert "/fingertip/taxels" in topics_at_end(file)
    for data in (whole[:-100], whole[:-300] + b"?" + whole[-299:]):  # then the messages tell
        other = tmp_path / "other.mcap"
        other.write_bytes(data)
        with other.open("rb") as file:
            assert topics_at_end(file) == ()
        assert arrays(other) == ("lts210", "fingertip")
    recording = read_episode(path)
    assert recording.sensor == "lts210,fingertip"
    assert [item.pad for item in recording.frames()] == [0] * 300 + [1] * 20
    assert [pad.spec.name for pad in recording.pads] == ["lts210", "fingertip"]


def test_counts_that_are_not_whole_survive_in_single_precision(tmp_path):
    record(tmp_path / "e.mcap", 5, whole=False)
    frames = [item for item in read(tmp_path / "e.mcap") if isinstance(item, RecordedFrame)]
    for found, (frame, _, _) in zip(frames, episode(5, whole=False), strict=True):
        np.testing.assert_allclose(found.frame.counts, frame.counts, rtol=1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_a_recording_cut_anywhere_reads_as_a_prefix(recorded, tmp_path, seed):
    data = recorded.read_bytes()
    whole = [key(item) for item in read(recorded)]
    cut = tmp_path / "cut.mcap"
    lengths = []
    for at in np.random.default_rng(seed).integers(0, len(data), 15):
        cut.write_bytes(data[:at])
        found = [key(item) for item in read(cut)]
        assert found == whole[: len(found)]
        lengths.append(len(found))
    assert max(lengths) > len(whole) / 3


def test_a_damaged_byte_ends_the_reading_without_a_false_frame(recorded, tmp_path):
    data = bytearray(recorded.read_bytes())
    data[len(data) // 2] ^= 0xFF
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(data)
    whole = [key(item) for item in read(recorded)]
    found = [key(item) for item in read(broken)]
    assert found == whole[: len(found)]
    assert 0 < len(found) < len(whole)


def test_a_killed_recording_keeps_all_but_its_last_moments(tmp_path):
    script = """
import sys, time, numpy as np
from pathlib import Path
from exploration.recordings.mcap import Recorder
from exploration.sensing.frame import TaxelFrame
recorder, rng = Recorder(Path(sys.argv[1])), np.random.default_rng(0)
for i in range(1000):
    counts = np.round(rng.normal(300, 30, (10, 16)))
    recorder.frame("pad", TaxelFrame(counts, i / 200, i), np.eye(4), np.zeros(6))
print("recorded", flush=True)
time.sleep(60)
"""
    process = subprocess.Popen([sys.executable, "-c", script, tmp_path / "e.mcap"], stdout=subprocess.PIPE)
    try:
        assert process.stdout.readline().strip() == b"recorded"
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    assert 800 < sum(1 for _ in read(tmp_path / "e.mcap")) <= 1000


def test_other_tools_find_topics_schemas_and_images(recorded):
    with recorded.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        topics = {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
        assert topics == {
            "/lts210/taxels": "foxglove.RawImage",
            "/lts210/pose": "foxglove.FrameTransform",
            "/lts210/wrench": "palpate.Wrench",
            "/events": "palpate.Event",
            "/log": "foxglove.Log",
            "/scene": "foxglove.SceneUpdate",
        }
        assert sum(1 for _ in reader.iter_messages(["/lts210/taxels"])) == 300


FIELDS = {  # of Foxglove's published message types
    "foxglove.RawImage": "timestamp frame_id width height encoding step data",
    "foxglove.FrameTransform": "timestamp parent_frame_id child_frame_id translation rotation",
    "foxglove.Log": "timestamp level message name file line",
    "foxglove.SceneUpdate": "deletions entities",
    "entity": "timestamp frame_id id lifetime frame_locked metadata "
    "arrows cubes spheres cylinders lines triangles texts models",
}


def test_messages_have_the_fields_of_the_well_known_types(recorded):
    seen = {}
    with recorded.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            body = json.loads(message.data)
            assert channel.message_encoding == "json"
            assert schema.encoding == "jsonschema"
            told = json.loads(schema.data)
            assert told["title"] == schema.name
            assert set(body) == set(told["properties"])
            seen[schema.name] = body
    seen["entity"] = seen["foxglove.SceneUpdate"]["entities"][0]
    for name, fields in FIELDS.items():
        assert set(seen[name]) == set(fields.split())
    image, entity = seen["foxglove.RawImage"], seen["entity"]
    assert len(base64.b64decode(image["data"])) == image["step"] * image["height"]
    assert image["step"] == image["width"] * {"mono16": 2, "32FC1": 4}[image["encoding"]]
    assert entity["frame_id"] == seen["foxglove.FrameTransform"]["child_frame_id"] == "lts210"
    assert entity["cubes"][0]["size"] == {"x": 0.0288, "y": 0.018, "z": 0.002}
    assert "index 5" in seen["foxglove.Log"]["message"]


def test_what_is_no_recording_is_refused_in_one_line(tmp_path):
    path = tmp_path / "e.mcap"
    path.write_text("a plain text")
    with pytest.raises(PalpateError, match="not an MCAP recording"):
        list(read(path))
    with pytest.raises(PalpateError, match="cannot read"):
        list(read(tmp_path / "absent.mcap"))
    with pytest.raises(PalpateError, match="cannot read"):
        list(read(tmp_path))


def test_an_empty_recording_holds_nothing(tmp_path):
    (tmp_path / "e.mcap").touch()
    assert list(read(tmp_path / "e.mcap")) == []
    with Recorder(tmp_path / "f.mcap"):
        pass
    assert list(read(tmp_path / "f.mcap")) == []


def test_a_full_disk_is_one_line():
    with pytest.raises(PalpateError, match="No space left"):
        record(Path("/dev/full"), 400)


def test_the_caller_may_reuse_its_buffers(tmp_path):
    counts, place = np.zeros((2, 2)), np.eye(4)
    with Recorder(tmp_path / "e.mcap") as recorder:
        for i in range(3):
            counts[:] = i
            place[0, 3] = i
            recorder.frame("pad", TaxelFrame(counts, time.time(), i), place, np.zeros(6))
    for i, item in enumerate(read(tmp_path / "e.mcap")):
        assert (item.frame.counts == i).all()
        assert item.world_from_sensor[0, 3] == pytest.approx(i)
