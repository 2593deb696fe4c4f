"""The surface under a pad that an edge cuts, read on from the last reading."""

import numpy as np

from exploration.control import surface_reading
from exploration.control.feel import feel
from exploration.control.surface_reading import read_surface
from models.csg import Cube
from primitives import pose as se3

DOWN = np.diag([1.0, -1.0, -1.0])


def test_what_an_edge_cuts_is_read_as_well_as_if_nothing_had_been_given_up(over, monkeypatch):
    guard, _ = over(Cube((60.0, 60.0, 40.0)), se3.pose(DOWN, [15.0, 2.0, 20.3]))
    dropped = guard.move(np.array([0.0, 0.0, 40.0, 0.0, 0.0, 0.0]))
    while dropped.force < 25.0:
        dropped = guard.move(np.array([0.0, 0.0, 40.0, 0.0, 0.0, 0.0]))
    seen, last, fits = guard.hold(5), None, []
    fit_dome = surface_reading.fit_dome
    monkeypatch.setattr(surface_reading, "fit_dome", lambda contact: fits.append(1) or fit_dome(contact))
    cut = 0
    for _ in range(60):
        felt = feel(seen.image)
        afresh = read_surface(seen, felt)
        fits.clear()
        reading = read_surface(seen, felt, last)
        assert reading is not None
        assert reading.whole == afresh.whole
        assert np.abs(reading.coefficients - afresh.coefficients)[:3].max() < 0.002
        cut += not reading.whole
        if last is not None:
            assert not fits
        last, seen = reading, guard.move(np.array([20.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert cut > 20
