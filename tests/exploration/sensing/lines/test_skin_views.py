import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exploration.sensing.lines.skin_views import skin_views


@settings(max_examples=30, deadline=None)
@given(
    rows=st.integers(2, 12),
    columns=st.integers(2, 16),
    pitch=st.floats(0.5, 5.0),
    skin=st.floats(0.0, 4.0),
    width=st.floats(0.4, 2.0),
)
def test_each_taxel_sees_the_whole_press_once_and_nothing_past_the_skin(rows, columns, pitch, skin, width):
    variance = (width * pitch) ** 2
    pad = skin_views(rows, columns, (pitch, pitch), skin * pitch, (variance, variance))
    weight = np.add.reduceat(pad.views[2], pad.first[:-1])
    assert weight == pytest.approx(np.ones(rows * columns))
    assert np.abs(pad.views[0]).max() <= (columns / 2 + skin) * pitch
    assert np.abs(pad.views[1]).max() <= (rows / 2 + skin) * pitch
    assert (pad.blurs <= variance * (1 + 1e-9)).all()


def test_an_endless_skin_gives_each_taxel_one_view_at_its_center():
    pad = skin_views(3, 5, (2.0, 1.0), np.inf, (4.0, 3.0))
    assert pad.views.shape == (3, 15)
    assert pad.views[0].reshape(3, 5)[0] == pytest.approx([-4.0, -2.0, 0.0, 2.0, 4.0])
    assert pad.blurs.tolist() == [[4.0, 3.0]]
