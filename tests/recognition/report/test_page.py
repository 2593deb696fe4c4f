import base64
import json
import re
import time
from dataclasses import replace

import numpy as np
import pytest

from recognition.report.page import report_html, write_report
from recognition.report.payload import PayloadLimits, payload
from recognition.report.run_report import EMPTY_FRAMES, ReportFrames, ReportMesh


@pytest.fixture(scope="module")
def page(report, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    write_report(path, report)
    return path


@pytest.fixture(scope="module")
def identified(report):
    """An identification, of which the page shows what was believed."""
    history = [
        {"touch": 1, "top": [["block", 0.7], ["post", 0.2]], "entropy_bits": 1.2, "felt": "a flat face"},
        {"touch": 2, "top": [["post", 0.97], ["rod", 0.03]], "entropy_bits": 0.2, "felt": "an edge"},
    ]
    summary = {
        "command": "identify",
        "part": "post",
        "decision": "post",
        "confidence": 0.97,
        "ended": "sure",
        "library": {"objects": 3, "folder": None},
        "candidates": [{"name": "post", "probability": 0.97, "pose_sigma": {"translation_mm": 0.1}}],
        "history": [step | {"device_seconds": 6.0 * step["touch"]} for step in history],
        "truth": {"name": "post", "correct": True, "translation_error_mm": 0.1, "rotation_error_deg": 0.2},
    }
    return replace(report, summary=summary)


@pytest.fixture
def opened(browser, page):
    browser.open(page)
    return browser


def embedded(html):
    return json.loads(re.search(r'id="data">(.*?)</script>', html, re.DOTALL)[1])


def test_the_page_names_no_other_file(page):
    html = page.read_text(encoding="utf-8")
    assert not re.search(r"(src|href)\s*=|url\(|import\s*\(|fetch\(|https?://", html)


def test_what_the_run_is_called_cannot_become_markup(report):
    html = report_html(report)
    assert "<h1>post &lt;b&gt;</h1>" in html
    hostile = replace(
        report, summary={**report.summary, "part": "{{data}}</script>", "warnings": ["<script>"]}
    )
    html = report_html(hostile)
    assert html.count("</script>") == 2
    assert "<h1>{{data}}&lt;/script&gt;</h1>" in html


def test_a_large_run_stays_below_five_megabytes(report):
    rng = np.random.default_rng(0)
    n = 30_000
    frames = ReportFrames(
        np.arange(n) / 200,
        np.broadcast_to(np.eye(4), (n, 4, 4)),
        rng.uniform(0, 255, (n, 32, 32)).astype(np.float32),
        np.zeros(n),
        np.zeros(n, dtype=np.int64),
        [np.zeros((3, 2))] * n,
    )
    points = rng.normal(size=(200_000, 3))
    mesh = ReportMesh(points[:20_000], rng.integers(0, 20_000, (30_000, 3)), rng.integers(0, 40, 30_000))
    large = replace(
        report,
        frames=frames,
        contacts=points,
        contact_face=np.zeros(len(points), dtype=np.int64),
        model=mesh,
        truth=replace(mesh, triangles=np.tile(mesh.triangles, (2, 1)), face=np.tile(mesh.face, 2)),
        traces=(points, points[:7]),
    )
    html = report_html(large)
    assert len(html.encode()) < 5_000_000
    assert "mesh has 60000 triangles and is not drawn here" in html


def test_thinning_keeps_the_first_and_the_last_frame(report):
    data = payload(report, PayloadLimits(frames=100))
    times = np.frombuffer(base64.b64decode(data["frames"]["times"]["base64"]), "<f4")
    assert len(times) == 100
    assert times[0] == 0
    assert times[-1] == pytest.approx(report.frames.times[-1])


def test_the_outline_of_a_cylinder_is_its_two_rims(report):
    data = payload(report)["model"]["edges"]
    segments = np.frombuffer(base64.b64decode(data["base64"]), "<f4").reshape(-1, 2, 3)
    assert len(segments) == 96
    np.testing.assert_allclose(np.hypot(segments[..., 0], segments[..., 1]), 20, rtol=1e-6)


@pytest.mark.slow
def test_the_browser_has_nothing_to_complain_of(opened):
    opened.evaluate("new Promise(done => setTimeout(done, 200))")
    assert opened.complaints() == []


@pytest.mark.slow
def test_the_slider_moves_the_pad_and_redraws_the_view(opened):
    def at(moment):
        return opened.evaluate(
            f"""(async () => {{
              const slider = document.getElementById("moment");
              slider.value = {moment};
              slider.dispatchEvent(new Event("input"));
              await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
              return [Array.from(palpate.scene.padPose()).slice(12, 15),
                      document.getElementById("view").toDataURL(),
                      document.getElementById("now-pad").textContent];
            }})()"""
        )

    (early, early_view, early_text), (late, late_view, late_text) = at(100), at(700)
    assert np.linalg.norm(np.subtract(early, late)) > 5
    assert early_view != late_view
    assert early_text != late_text


@pytest.mark.slow
def test_every_layer_changes_the_picture(opened):
    different = opened.evaluate(
        """(async () => {
          const shot = async () => {
            await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
            return document.getElementById("view").toDataURL();
          };
          const out = {};
          for (const box of document.querySelectorAll("[data-layer]")) {
            const before = await shot();
            box.click();
            out[box.dataset.layer] = before !== await shot();
            box.click();
          }
          return out;
        })()"""
    )
    assert different == dict.fromkeys(("model", "off", "truth", "contacts", "traces", "pad"), True)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nobody_is_shut_out(browser, axe, report, identified, tmp_path, scheme):
    for told in (report, identified):
        write_report(tmp_path / "report.html", told)
        browser.open(tmp_path / "report.html", scheme)
        assert browser.violations(axe) == []


@pytest.mark.slow
def test_contacts_come_as_time_goes_on(opened):
    felt = """((moment) => { palpate.show(moment);
      return palpate.scene.felt(palpate.data.contacts.from, palpate.scene.layers.contacts, 1); })"""
    counts = [opened.evaluate(f"{felt}({moment})") for moment in (0, 400, 1400)]
    assert counts[0] < counts[1] < counts[2]


@pytest.mark.slow
def test_belief_is_that_of_the_moment(browser, identified, tmp_path):
    write_report(tmp_path / "report.html", identified)
    browser.open(tmp_path / "report.html")
    seen = """((moment) => { palpate.show(moment);
      return [...document.querySelectorAll("#names li")].map((item) => item.innerText.replace("\\n", " ")); })"""
    assert browser.evaluate(f"{seen}(0)") == ["post –", "rod –", "block –"]
    assert browser.evaluate(f"{seen}(1499)") == ["post 97 %", "rod 3 %", "block 0 %"]
    assert browser.complaints() == []


@pytest.mark.slow
def test_the_last_frame_shows_the_belief_of_a_touch_that_ended_after_it(browser, identified, tmp_path):
    first, last = identified.summary["history"]
    history = [first, last | {"device_seconds": 1e4}]
    write_report(
        tmp_path / "report.html", replace(identified, summary={**identified.summary, "history": history})
    )
    browser.open(tmp_path / "report.html")
    seen = "((moment) => { palpate.show(moment); return document.getElementById('felt').innerText; })"
    assert browser.evaluate(f"{seen}(1498)") == "touch 1: a flat face"
    assert browser.evaluate(f"{seen}(1499)") == "touch 2: an edge"


@pytest.mark.slow
def test_keys_turn_the_view_and_play_the_run(opened):
    opened.evaluate("document.getElementById('view').focus()")
    before = opened.evaluate("[palpate.scene.camera.yaw, palpate.scene.camera.distance]")
    for key in ("ArrowLeft", "+", " "):
        opened.call("Input.dispatchKeyEvent", type="keyDown", key=key, text=key if len(key) == 1 else "")
        opened.call("Input.dispatchKeyEvent", type="keyUp", key=key)
    after = opened.evaluate("[palpate.scene.camera.yaw, palpate.scene.camera.distance]")
    assert after[0] != before[0]
    assert after[1] < before[1]
    start = opened.evaluate("+document.getElementById('moment').value")
    end = time.monotonic() + 10
    while opened.evaluate("+document.getElementById('moment').value") <= start:
        assert time.monotonic() < end, "the run does not play"


@pytest.mark.slow
def test_a_run_that_felt_nothing_still_has_a_page(browser, report, tmp_path):
    summary = {"command": "explore", "part": "block", "closed": False, "ended": "budget", "touches": 1}
    nothing = replace(
        report,
        summary=summary,
        model=None,
        truth=None,
        traces=(),
        frames=EMPTY_FRAMES,
        contacts=np.empty((0, 3)),
        contact_face=np.empty(0, dtype=np.int64),
    )
    write_report(tmp_path / "report.html", nothing)
    browser.open(tmp_path / "report.html", "dark")
    assert browser.complaints() == []
