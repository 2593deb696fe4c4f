"""What docs/hardware.md tells a reader to write down works as it is written there."""

import re
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from exploration.devices.safety import Safety, SafetyLimits
from exploration.devices.watched_stage import WatchedStage
from exploration.devices.wire import line_text
from exploration.sensing.calibration import Calibration
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.spec import load_sensor
from primitives import pose as se3
from primitives.errors import PalpateError
from recognition.hardware.config import StageConfig
from recognition.hardware.driver import driven

PAGE = (Path(__file__).parents[1] / "docs" / "hardware.md").read_text(encoding="utf-8")
LTS = load_sensor("lts210")

VENDOR = """
import time

class Controller:
    def __init__(self, port):
        self.q, self.goal, self.rate, self.then = [0.2, 0.5, 0.9, 0.1, 1.1, 0.3], None, 0.0, time.monotonic()
    def joints(self):
        now = time.monotonic()
        passed, self.then = now - self.then, now
        if self.goal is not None:
            steps = [min(abs(g - q), self.rate * passed) * (1 if g > q else -1) for g, q in zip(self.goal, self.q)]
            self.q = [q + s for q, s in zip(self.q, steps)]
        return list(self.q)
    def servo(self, joints, seconds):
        here = self.joints()
        self.goal, self.rate = joints, max(abs(g - q) for g, q in zip(joints, here)) / seconds
    def stop(self):
        self.joints()
        self.goal = None
"""

BOARD = """
#include <cstdio>
#include <string>
typedef unsigned char byte;
const int A0 = 0, A1 = 1, A2 = 2, A3 = 3, A4 = 4, A5 = 5, A6 = 6, A7 = 7, OUTPUT = 1, HIGH = 1, LOW = 0;
static unsigned long clock_us = 0; static int driven = 0;
unsigned long micros() { return clock_us += 500; }
unsigned long millis() { return clock_us / 1000; }
void delayMicroseconds(int) {}
void pinMode(int, int) {}
void digitalWrite(int pin, int on) { if (on) driven = pin - 2; }
int analogRead(int column) { return 100 * driven + column; }
struct {
  void begin(int) {}
  void print(char c) { putchar(c); }
  void print(const char* s) { printf("%s", s); }
} Serial;
"""


def block(language: str) -> str:
    return re.search(rf"```{language}\n(.*?)```", PAGE, re.S)[1]


@pytest.fixture
def arm(tmp_path, monkeypatch):
    (tmp_path / "arm.py").write_text(block("python"))
    (tmp_path / "vendor.py").write_text(VENDOR)
    monkeypatch.syspath_prepend(str(tmp_path))
    return driven(tmp_path / "rig.toml", StageConfig("port", driver="arm.py:Arm"))


def until_still(stage) -> None:
    end = time.monotonic() + 240.0
    while stage.moving and time.monotonic() < end:
        time.sleep(0.005)


def test_the_stage_of_the_page_goes_where_it_is_told(arm):
    goal = arm.pose() @ se3.pose(se3.rotation_exp([0.1, -0.05, 0.2]), [8.0, -5.0, 6.0])
    arm.go_to(goal)
    until_still(arm)
    time.sleep(0.1)
    assert np.allclose(arm.pose()[:3, 3], goal[:3, 3], atol=0.1)
    assert np.allclose(arm.pose()[:3, :3], goal[:3, :3], atol=2e-3)
    assert sum(bool(line.strip()) for line in block("python").splitlines()) <= 30


def test_the_stage_of_the_page_is_watched_by_the_same_limits(arm):
    calibration = Calibration.nominal(LTS)
    safety = Safety(calibration, LTS.array.pitch[0] * LTS.array.pitch[1], 10.0, SafetyLimits(force=5.0))
    stage = WatchedStage(arm, safety)
    stage.start()
    try:
        start = stage.pose()
        for _ in range(30):
            stage.move(np.array([0.0, 0.0, -20.0, 0.0, 0.0, 0.0]))
            time.sleep(0.01)
        moved = (np.linalg.inv(start) @ stage.pose())[:3, 3]
        assert moved[2] < -1.0
        assert np.abs(moved[:2]).max() < 0.3 * abs(moved[2])
        safety.seen(TaxelFrame(np.full(LTS.array.shape, 200.0), 0.0, 0))
        time.sleep(0.1)
        held = stage.pose()
        stage.move(np.array([0.0, 0.0, 20.0, 0.0, 0.0, 0.0]))
        time.sleep(0.1)
        assert np.allclose(stage.pose(), held, atol=1e-6)
    finally:
        stage.close()


@pytest.mark.parametrize("driver", ["arm.py", "none.py:Arm", "arm.py:Leg"])
def test_a_driver_that_is_not_there_is_refused_in_one_line(arm, tmp_path, driver):
    with pytest.raises(PalpateError, match=r"arm\.py|none\.py") as caught:
        driven(tmp_path / "rig.toml", StageConfig("port", driver=driver))
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler")
def test_the_firmware_of_the_page_sends_frames_that_are_read(tmp_path):
    source = tmp_path / "board.cpp"
    source.write_text(BOARD + block("cpp") + "int main() { setup(); for (int k = 0; k < 3; k++) loop(); }")
    subprocess.run(["g++", "-o", tmp_path / "board", source], check=True, capture_output=True)
    sent = subprocess.run([tmp_path / "board"], check=True, capture_output=True).stdout
    cut = line_text.cut(sent, 64)
    assert cut.skipped == 0
    assert [frame.sequence for frame in cut.frames] == [0, 1, 2]
    assert (cut.frames[-1].counts.reshape(8, 8) == 100 * np.arange(8)[:, None] + np.arange(8)).all()
