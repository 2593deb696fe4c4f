"""A headless browser to look at pages with; the same examples of every property in every run; its own cache."""

import base64
import importlib.util
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("same", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("same")


def pytest_collection_modifyitems(config, items):
    """Where workers share the tests the slow ones come first, so that none is left alone with one at the end."""
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: not any(item.get_closest_marker(name) for name in ("slow", "long")))


# Tests write nothing outside the checkout; what recognition keeps of built-in parts is made once for all workers.
os.environ["XDG_CACHE_HOME"] = str(Path(__file__).parents[1] / ".pytest_cache" / "home")


class Browser:
    """One page in headless Chromium, spoken to through `--remote-debugging-pipe`."""

    def __init__(self, executable, width=1240, height=1500):
        import fcntl  # not on Windows, where other tests still run

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
