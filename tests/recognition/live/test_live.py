"""Runs served: to this machine, nothing but their page, and what was felt so far while they go on."""

import json
import threading
import time
import urllib.error
import urllib.request

import pytest

from primitives.errors import PalpateError
from recognition.live.replay import serving
from recognition.live.server import parse_address
from recognition.live.view import shown
from recognition.running.progress import Progress


def fetched(address, host=None):
    request = urllib.request.Request(address, headers={"Host": host} if host else {})
    return urllib.request.urlopen(request, timeout=20).read().decode()


@pytest.fixture
def address(tmp_path):
    (tmp_path / "report.html").write_text("<p>here</p>")
    (tmp_path / "secret.txt").write_text("no")
    with serving(tmp_path) as made:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{made.server_address[1]}"
        made.shutdown()


def test_the_page_is_there(address):
    assert fetched(f"{address}/") == "<p>here</p>"


@pytest.mark.parametrize(
    ("path", "host", "code"),
    [("/secret.txt", None, 404), ("/", "evil.example:80", 403), ("/", "10.1.2.3:80", 403)],
)
def test_nothing_else_is_answered(address, path, host, code):
    with pytest.raises(urllib.error.HTTPError) as error:
        fetched(address + path, host)
    assert error.value.code == code


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(PalpateError, match="give the folder of a run"):
        serving(tmp_path)


@pytest.mark.parametrize(
    ("text", "parsed"),
    [("", ("127.0.0.1", 0)), (":81", ("127.0.0.1", 81)), ("h:5", ("h", 5)), ("h", ("h", 0))],
)
def test_an_address_may_leave_either_part_out(text, parsed):
    assert parse_address(text) == parsed


def test_a_port_that_is_none_is_refused():
    with pytest.raises(PalpateError, match="HOST:PORT"):
        parse_address("localhost:web")


def test_who_looks_sees_what_was_felt_so_far_and_then_the_whole_page(report, tmp_path):
    said, told, answers = [], [], []

    def look(at):
        fetched(at)
        answers.append(json.loads(fetched(f"{at}now?after=")))
        started.set()
        while True:
            answers.append(json.loads(fetched(f"{at}now?after={answers[-1]['number']}")))
            if answers[-1]["done"]:
                answers.append(fetched(at))
                return
            time.sleep(0.05)

    started = threading.Event()
    with shown("", told.append, said.append) as show:
        viewer = threading.Thread(target=look, args=(said[0].removeprefix("live at "),))
        viewer.start()
        assert started.wait(20)
        for touch in range(3):
            show(Progress("exploring", touch, folder=tmp_path, page=lambda: report))
            time.sleep(0.2)
        (tmp_path / "report.html").write_text("whole")
    viewer.join(20)
    drawn = [answer["data"] for answer in answers[:-1] if answer["data"]]
    assert drawn[0]["frames"]["count"] == 1500
    assert answers[-1] == "whole"
    assert len(told) == 3


def test_nobody_who_looks_costs_no_drawing():
    def page():
        raise AssertionError("nobody asked")

    with shown("", lambda progress: None, lambda text: None) as show:
        show(Progress("exploring", page=page))


@pytest.mark.slow
def test_the_live_page_grows_without_a_complaint(browser, report):
    said = []
    with shown("", lambda progress: None, said.append) as show:
        browser.visit(said[0].removeprefix("live at "))
        end = time.monotonic() + 30
        while browser.evaluate("palpate.scene.data.frames.count") == 0:
            assert time.monotonic() < end, "nothing comes"
            show(Progress("exploring", 3, page=lambda: report))
            time.sleep(0.1)
        assert "exploring: 3 touches" in browser.evaluate("document.getElementById('stand').textContent")
        others = [c for c in browser.complaints() if not str(c).startswith("http://127.0.0.1")]
        assert others == []
        browser.evaluate("location.href = 'about:blank'")
