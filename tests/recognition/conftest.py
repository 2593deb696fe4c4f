"""A made-up run to report, and a headless browser to look at the page with."""

import base64
import fcntl
import importlib.util
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from primitives.pose import frame_along, pose
from recognition.report.run_report import Deviation, ReportFrames, ReportMesh, RunReport


def cylinder_mesh(radius, height, sides=48):
    angle = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    low, high = (np.column_stack([ring, np.full(sides, z)]) for z in (0.0, height))
    vertices = np.concatenate([low, high, [[0, 0, 0], [0, 0, height]]])
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    b, t = np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    triangles = np.concatenate(
        [
            np.stack([i, j, j + sides], 1),
            np.stack([i, j + sides, i + sides], 1),
            np.stack([b, j, i], 1),
            np.stack([t, i + sides, j + sides], 1),
        ]
    )
    return ReportMesh(vertices, triangles, np.repeat([0, 0, 1, 2], sides))


def made_up_report(frame_count=2000, rows=10, columns=16):
    radius, height = 20.0, 45.0
    rng = np.random.default_rng(3)
    mesh = cylinder_mesh(radius, height)
    turn = rng.uniform(0, 2 * np.pi, 1500)
    wall = np.stack([radius * np.cos(turn), radius * np.sin(turn), rng.uniform(0, height, 1500)], axis=1)
    times = np.arange(frame_count) / 100.0
    around = 2 * np.pi * times / times[-1] * 3
    normals = np.stack([np.cos(around), np.sin(around), np.zeros(frame_count)], axis=1)
    lifted = np.maximum(0.0, np.sin(around * 4)) * 8
    centers = (
        normals * (radius + lifted)[:, None] + [0, 0, 1] * (height * (0.3 + 0.6 * times / times[-1]))[:, None]
    )
    poses = np.stack([pose(frame_along(-n, [0, 0, 1.0]), c) for n, c in zip(normals, centers, strict=True)])
    touching = lifted < 0.5
    x = (np.arange(columns) - (columns - 1) / 2) * 1.8
    y = (np.arange(rows) - (rows - 1) / 2) * 1.8
    edge = (x[None, None, :] < (4 * np.cos(around))[:, None, None]) * np.exp(-((y / 5) ** 2))[None, :, None]
    counts = 10 + 190 * edge * touching[:, None, None] + rng.normal(0, 2, (frame_count, rows, columns))
    lines = [
        np.array([[np.pi / 2, -4 * np.cos(a)]]) if on else np.empty((0, 2))
        for a, on in zip(around, touching, strict=True)
    ]
    rim = np.stack(
        [
            radius * np.cos(np.linspace(0, 6.2, 200)),
            radius * np.sin(np.linspace(0, 6.2, 200)),
            np.full(200, height),
        ],
        1,
    )
    touch = np.where(touching, np.cumsum(np.diff(touching, prepend=False) & touching) - 1, -1)
    summary = {
        "command": "explore",
        "version": "0.1.0",
        "part": "post <b>",
        "sensor": "lts210",
        "seed": 3,
        "closed": True,
        "ended": "closed",
        "touches": int(touch.max() + 1),
        "strokes": 18,
        "frames": frame_count,
        "travel_mm": 2120.5,
        "device_seconds": 20.0,
        "wall_seconds": 1.7,
        "volume_mm3": 56548.7,
        "faces": [
            {
                "id": 0,
                "shape": "cylinder",
                "status": "measured",
                "convex": True,
                "extent_mm": [45.01, 125.7],
                "area_mm2": 5654.9,
                "parameters": {"origin_mm": [0, 0, 22.5], "axis": [0, 0, 1], "radius_mm": 20.004},
                "sigma": {"radius_mm": 0.008},
            },
            {
                "id": 1,
                "shape": "plane",
                "status": "measured",
                "convex": True,
                "extent_mm": [40.0, 40.0],
                "area_mm2": 1256.6,
                "parameters": {"origin_mm": [0, 0, 0], "axis": [0, 0, -1]},
                "sigma": {},
            },
            {
                "id": 2,
                "shape": "plane",
                "status": "inferred",
                "convex": True,
                "extent_mm": [40.0, 40.0],
                "area_mm2": 1256.6,
                "parameters": {"origin_mm": [0, 0, 45], "axis": [0, 0, 1]},
                "sigma": {},
            },
        ],
        "edges": [
            {
                "id": i,
                "faces": [0, i + 1],
                "kind": "convex",
                "curve": "circle",
                "length_mm": 125.7,
                "dihedral_deg": 90.0,
                "status": "measured",
            }
            for i in range(2)
        ],
        "primitives": [
            {
                "kind": "cylinder",
                "operation": "add",
                "extent_mm": [40, 40, 45.0],
                "pose": {"translation_mm": [0, 0, 22.5], "quaternion_wxyz": [1, 0, 0, 0]},
            }
        ],
        "truth": {
            "iou": 0.9982,
            "hausdorff_mm": 0.11,
            "surface_rms_mm": 0.031,
            "face_shape_accuracy": 1.0,
            "extent_error_mm": {"median": 0.02, "max": 0.06},
        },
        "warnings": ["face 2 was outlined but not pressed in its middle"],
    }
    ghost = ReportMesh(mesh.vertices * [1.01, 1.01, 1.0], mesh.triangles, mesh.face)
    off = Deviation(mesh, np.where(mesh.vertices[:, 2] > 1, 0.05, -0.02), 0.05)
    return RunReport(
        summary=summary,
        settings={"part": "post", "seed": 3, "sensors": ["lts210"], "noise": 0.05, "feature_mm": 10.0},
        model=mesh,
        truth=ghost,
        off=off,
        contacts=wall,
        contact_face=np.zeros(len(wall), dtype=np.int64),
        traces=(rim,),
        frames=ReportFrames(
            times, poses, counts, np.where(touching, 4 + np.sin(9 * around), 0.0), touch, lines
        ),
        pad_size=(28.8, 18.0),
        housing_size=(34.0, 24.0, 14.0),
    )


@pytest.fixture(scope="session")
def report():
    return made_up_report()


class Browser:
    """One page in headless Chromium, spoken to through `--remote-debugging-pipe`."""

    def __init__(self, executable, width=1240, height=1500):
        self.profile = tempfile.mkdtemp(prefix="palpate-chromium-")
        from_us, self._write = os.pipe()
        self._read, to_us = os.pipe()
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 30) for end in (from_us, to_us)]

        def wire():
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        flags = (
            "--headless --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic "
            "--no-first-run --disable-background-networking --disable-component-update --disable-sync "
            "--remote-debugging-pipe"
        )
        self.process = subprocess.Popen(
            [executable, *flags.split(), f"--user-data-dir={self.profile}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            close_fds=False,
            preexec_fn=wire,
            env={**os.environ, "HOME": self.profile},
        )
        for end in (from_us, to_us, *ends):
            os.close(end)
        self.events, self._buffer, self._number, self._session = [], b"", 0, None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def call(self, method, **params):
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while (answer := self._receive()).get("id") != self._number:
            self.events.append(answer)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def _receive(self, seconds=60):
        end = time.monotonic() + seconds
        while b"\0" not in self._buffer:
            if not select.select([self._read], [], [], max(0.0, end - time.monotonic()))[0]:
                raise TimeoutError("Chromium does not answer")
            data = os.read(self._read, 1 << 20)
            if not data:
                raise RuntimeError("Chromium has ended")
            self._buffer += data
        text, _, self._buffer = self._buffer.partition(b"\0")
        return json.loads(text)

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def visit(self, address):
        """Open a page that is served."""
        self.events.clear()
        self.call("Page.navigate", url=address)
        self._wait("document.documentElement?.dataset.ready")

    def open(self, path, scheme="light", ready=True):
        """Open a page; `ready`: wait until its script says that it is."""
        self.events.clear()
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.call("Page.navigate", url=Path(path).resolve().as_uri())
        self._wait("document.documentElement?.dataset.ready" if ready else "document.readyState")

    def _wait(self, told):
        end = time.monotonic() + 60
        while self.evaluate(told) not in ("yes", "complete"):
            assert time.monotonic() < end, self.complaints() or "the page does not get ready"
            time.sleep(0.05)

    def complaints(self):
        """Errors and warnings of the console, uncaught exceptions, and every request but the page's own."""
        out = []
        for event in self.events:
            method, params = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                out.append(params["exceptionDetails"])
            elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
                out.append(params["args"])
            elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
                out.append(params["entry"]["text"])
            elif method == "Network.requestWillBeSent" and not params["request"]["url"].startswith("file:"):
                out.append(params["request"]["url"])
        return out

    def violations(self, axe):
        """What axe-core finds serious or worse; `axe` is its script."""
        self.call("Page.setBypassCSP", enabled=True)
        self.call("Page.reload")
        time.sleep(0.5)
        self._wait("document.readyState")
        self.evaluate(axe + ";0")
        found = self.evaluate(
            """axe.run().then((found) => found.violations
              .filter((rule) => ["serious", "critical"].includes(rule.impact))
              .map((rule) => `${rule.id}: ${rule.nodes[0].html.slice(0, 200)}`))"""
        )
        self.call("Page.setBypassCSP", enabled=False)
        return found

    def screenshot(self, path):
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True)["data"]
        Path(path).write_bytes(base64.b64decode(data))

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self._read)
        os.close(self._write)
        shutil.rmtree(self.profile, ignore_errors=True)


@pytest.fixture(scope="session")
def axe():
    """The script of axe-core, which tries a page on those who cannot see it, or use no mouse."""
    found = importlib.util.find_spec("axe_core_python")
    if found is None:
        pytest.skip("left out: no axe-core here (pip install axe-core-python)")
    return (Path(found.origin).parent / "axe.min.js").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def browser():
    executable = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if executable is None:
        pytest.skip("left out: no Chromium here (Debian: apt-get install chromium)")
    browser = Browser(executable)
    yield browser
    browser.close()
