"""Pictures of flat faces on the page, and in the recording."""

import base64
import io
import re

import numpy as np
from PIL import Image

from exploration.planning.known.face_pictures import FacePicture
from recognition.report.run_report import SkinPicture
from recognition.report.skin_pictures import of_faces, skin_pictures
from recognition.running.picture_log import picture, told

SHARE = np.full((6, 4), np.nan)
SHARE[1:5, 1:3] = 0.0
SHARE[2:4, 1:3] = [[1.0, 0.5], [1.0, 1.3]]
SEEN = FacePicture(np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.6, 0.8]), SHARE, 0.5)


def opacity(html):
    (raw,) = {base64.b64decode(found) for found in re.findall(r"base64,([A-Za-z0-9+/=]+)\)", html)}
    return np.asarray(Image.open(io.BytesIO(raw)).convert("LA"))[..., 1]


def test_a_picture_is_inked_where_the_face_is_pale_where_it_is_not_and_blank_where_nobody_looked():
    ink = opacity(skin_pictures([SkinPicture(3, SHARE, 0.5)]))
    assert ink.shape == (4, 6)  # y up, x to the right
    assert ink[3, 0] == 0
    assert 0 < ink[2, 1] < 60
    assert ink[2, 2] == 255
    assert 100 < ink[1, 2] < 180


def test_pictures_are_to_one_scale_and_named_after_their_faces():
    html = skin_pictures([SkinPicture(3, SHARE, 0.5), SkinPicture(None, np.ones((12, 4)), 0.5)])
    assert re.findall(r"width:(\d+)px", html) == ["260", "130"]
    assert "Face 3" in html
    assert "A face" in html
    assert skin_pictures([]) == ""


def test_a_picture_is_of_the_largest_face_in_its_plane_that_looks_its_way():
    def row(number, axis, area, origin=(1.0, 2.0, 3.0), shape="plane"):
        told = {"axis": axis, "origin_mm": list(origin)}
        return {"id": number, "shape": shape, "parameters": told, "area_mm2": area}

    faces = [
        row(0, [0.0, -0.6, -0.8], 90.0),
        row(1, [0.0, 0.6, 0.8], 20.0),
        row(2, [0.0, 0.6, 0.8], 50.0),
        row(3, [0.0, 0.6, 0.8], 70.0, (1.0, 2.0, 9.0)),
        row(4, [0.0, 0.6, 0.8], 70.0, shape="cylinder"),
    ]
    assert of_faces([SEEN], faces)[0].face == 2
    assert of_faces([SEEN], faces[3:])[0].face is None


def test_a_picture_comes_back_from_the_recording():
    again = picture(told(SEEN))
    np.testing.assert_allclose(again.share, np.clip(SHARE, 0.0, 1.0), atol=0.003)
    np.testing.assert_array_equal(again.normal, SEEN.normal)
    assert again.step == 0.5
    assert picture({"share": "no"}) is None
