"""What a suite comes to: conditions kept apart, policies paired by part, names against touches."""

import copy
import re
from pathlib import Path

import pytest

from recognition.experiments.account import account
from recognition.experiments.rates import AREA, calibration, confusion, held
from recognition.experiments.suite import load_suite
from recognition.report.chart import Frame, Point, Series, dot_chart, line_chart
from recognition.report.suite_charts import charts
from recognition.report.suite_page import suite_html
from recognition.report.suite_terminal import suite_text

SUITE = """
name = "policies <b>"
about = "who touches best"
[[trials]]
kind = "identify"
part = ["block", "cylinder", "wedge"]
policy = ["information", "random"]
max_touches = 4
seeds = 2
[[trials]]
kind = "frames"
noise = [0.02, 0.05, 0.1]
detector = ["palpate", "erf fit"]
"""
HARD = {"block": 0, "cylinder": 1, "wedge": 2}  # touches that a part takes more


def row(trial):
    if trial.kind == "frames":
        share = 0.9 - trial.settings["noise"] - 0.2 * (trial.settings["detector"] == "erf fit")
        return trial.row("done", "", {"found_share": share, "false_lines": 1}, 1.0)
    late = 1 + HARD[trial.settings["part"]] + 2 * (trial.settings["policy"] == "random")
    marks = "".join("1" if touch >= late else "0" for touch in range(1, 5))
    right = marks[-1] == "1"
    told = {
        "decision": trial.settings["part"] if right else "unknown",
        "answer": trial.settings["part"],
        "correct": right,
        "confidence": 0.97,
        "touches": 4,
        "touches_to_correct": late if right else None,
        "first_touches_right": marks,
    }
    return trial.row("done", "", told, 1.0)


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    path = tmp_path_factory.mktemp("suite") / "policies.toml"
    path.write_text(SUITE)
    suite = load_suite(path)
    rows = [row(trial) for trial in suite.trials]
    rows[0] |= {"outcome": "failed", "reason": "a stranger"}
    return account(suite, rows, 1.0)


def test_conditions_are_not_averaged_over(told):
    policies, frames = told["groups"]
    assert [cell["settings"] for cell in policies["cells"]] == [
        {"policy": "information"},
        {"policy": "random"},
    ]
    assert len(frames["cells"]) == 6
    assert [cell["metrics"]["found_share"]["value"] for cell in frames["cells"]] == pytest.approx(
        [0.88, 0.68, 0.85, 0.65, 0.8, 0.6]
    )


def test_a_trial_that_failed_is_counted_and_not_averaged(told):
    cell = told["groups"][0]["cells"][0]
    assert cell["trials"] == 6
    assert cell["done"]["value"] == pytest.approx(5 / 6)
    assert cell["metrics"]["correct"]["count"] == 5


def test_policies_are_compared_on_the_trials_that_they_share(told):
    compared = {(c["metric"], c["second"]): c for c in told["groups"][0]["compared"]}
    area = compared[AREA, "random"]
    assert area["difference"]["count"] == 5  # the failed trial has no pair
    assert area["difference"]["units"] == 3
    assert area["by_part"] == pytest.approx({"block": -0.5, "cylinder": -0.5, "wedge": -0.5})
    assert area["second_better"]["value"] == 0.0
    found = [c for c in told["groups"][1]["compared"] if c["metric"] == "found_share"]
    assert [c["within"] for c in found] == [{"noise": n} for n in (0.02, 0.05, 0.1)]


def test_the_curve_of_touches_holds_what_led_last(told):
    assert held("01", 4) == [False, True, True, True]
    assert held("", 2) == [False, False]
    curve = [step["value"] for step in told["groups"][0]["cells"][1]["touch_curve"]]
    assert curve == pytest.approx([0, 0, 1 / 3, 2 / 3])


def test_calibration_sets_what_was_stated_beside_what_was_right():
    rows = [{"decision": "a", "correct": k < 8, "confidence": 0.96} for k in range(10)]
    found = calibration(rows, list(range(10)))
    (only,) = found["bins"]
    assert (only["from"], only["to"], only["value"]) == (0.95, 0.99, 0.8)
    assert found["expected_calibration_error"] == pytest.approx(0.16)
    assert found["brier"] == pytest.approx(0.8 * 0.04**2 + 0.2 * 0.96**2)


def test_confusion_counts_every_decision():
    rows = [{"answer": "a", "decision": d} for d in ("a", "b", "b", None)]
    assert {(c["answer"], c["decision"]): c["trials"] for c in confusion(rows)} == {
        ("a", "a"): 1,
        ("a", "b"): 2,
        ("a", "nothing"): 1,
    }


def test_the_page_draws_charts_and_speaks_in_words(told):
    html = suite_html(told)
    assert html.count("<svg") >= 8
    assert "Right names against touches" in html
    assert "Touch curve area: random less information" in html
    assert "touches_to_correct" not in html
    assert "policies &lt;b&gt;" in html
    assert "a stranger" in html
    assert "found share" in suite_text(told, Path("out"))


def test_the_terminal_says_how_many_were_done(told):
    lines = suite_text(told, Path("out")).splitlines()
    head = next(line for line in lines if line.lstrip().startswith("policy"))
    first = next(line for line in lines if line.lstrip().startswith("information"))
    assert head.split()[1:3] == ["trials", "done"]
    assert first.split()[1:3] == ["6", "5"]


def test_no_axis_goes_where_no_metric_can():
    for values, bounds, lowest, highest in (
        ([1.0, 1.0], (0.0, 1.0), 0.0, 1.0),
        ([0.0, 0.0], (0.0, float("inf")), 0.0, float("inf")),
        ([0.93, 0.99], (0.0, 1.0), 0.0, 1.0),
    ):
        dots = dot_chart(
            [Series(f"c{k}", [Point(0.0, v)]) for k, v in enumerate(values)], "t", "x", bounds=bounds
        )
        lines = line_chart(
            [Series("", [Point(float(k), v) for k, v in enumerate(values)])],
            Frame("t", "x", "y", y_bounds=bounds),
        )
        along = [float(t) for t in re.findall(r'text-anchor="middle">([-0-9.e]+)<', dots)]
        up = [float(t) for t in re.findall(r'text-anchor="end">([-0-9.e]+)<', lines)]
        for ticks in (along, up):
            assert len(ticks) > 1
            assert lowest <= min(ticks)
            assert max(ticks) <= highest


def test_a_condition_has_one_color_in_every_chart_of_its_group(told):
    group = copy.deepcopy(told["groups"][0])
    group["cells"][0]["touch_curve"] = []  # the first has nothing to show there
    curves, *others = charts(group).split("</figure>")
    assert "--name-1" in curves
    assert "--name-0" not in curves
    rows = re.findall(r'fill: (var\(--name-\d\))"/><text [^>]*>(information|random)<', "".join(others))
    assert rows
    assert set(rows) == {("var(--name-0)", "information"), ("var(--name-1)", "random")}


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_shuts_nobody_out(told, browser, axe, tmp_path, scheme):
    path = tmp_path / "report.html"
    path.write_text(suite_html(told), encoding="utf-8")
    browser.open(path, scheme, ready=False)
    assert browser.violations(axe) == []
    assert browser.complaints() == []
