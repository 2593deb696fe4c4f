"""The tables of a run's page, from its summary."""

import re

import numpy as np
import pytest

from recognition.report.run_words import _felt_with, figures, words
from recognition.report.shell import _resource
from recognition.report.tables import pairs, worded

EDGE = {
    "curve": "line",
    "length_mm": 29.98,
    "rms_mm": 0.031,
    "direction": np.array([1.0, 0.0, 0.0]),
    "center_mm": None,
    "radius_mm": None,
    "dihedral_deg": 90.2,
    "rounding_mm": 1.5,
    "rounding_sigma_mm": 0.1,
}


@pytest.mark.parametrize("as_list", [True, False])
def test_tracked_edges_are_a_table_and_nothing_is_printed_as_python_has_it(as_list):
    corners = np.eye(3)
    found = {
        "ended": "closed",
        "edges": [EDGE, EDGE | {"curve": "circle", "radius_mm": 8.0, "dihedral_deg": None}],
        "corners_mm": corners.tolist() if as_list else corners,
        "angles_between_deg": [90.0, None],
        "loop_gap_mm": None,
    }
    html = words({"command": "track"}).sections({"found": found})
    assert "<h2>Edges</h2>" in html
    assert ">29.98<" in html
    assert ">8.00<" in html
    assert "1.50 <small>± 0.1</small>" in html
    assert "1, 0, 0; 0, 1, 0; 0, 0, 1" in html
    assert not re.search(r"None|array\(|[\[\]{}]", html)


def test_a_number_in_a_name_is_read_as_one_and_keeps_its_unit():
    assert worded("share_within_0_1_mm") == "Share within 0.1 mm"
    assert worded("speed_mm_s") == "Speed, mm/s"
    assert worded("surface_rms_mm") == "Surface rms, mm"
    assert "None" not in pairs({"why": {"runner_up": None}, "list": [{"a": None, "b": 1.5}, None]})


def test_several_arrays_are_said_in_words():
    assert _felt_with({"sensor": "lts210,fingertip"}) == "felt with lts210 and fingertip"
    assert _felt_with({}) == "felt with a tactile array"


def test_a_cloud_is_told_by_its_contacts_and_not_by_a_run_that_never_was():
    told = {"command": "reconstruct", "frames": 0, "touches": 0, "contacts": 120, "contact_sigma_mm": 0.0512}
    assert "from 120 contacts" in words(told).lede(told)
    assert "0.0512" in figures(told)
    assert "Touches" not in figures(told)
    assert "Touches" in figures(told | {"frames": 40})


def test_what_only_frames_fill_is_marked_so():
    page = _resource("run_stage.html")
    assert page.index("data-frames") < page.index("Taxels")
    assert '"timeline" data-frames' in page
