"""Recognizing from files, in a folder where not every file can be read."""

import numpy as np

from models import parts
from models.formats.openscad.writer import write
from recognition.recognizing.run import Asked, recognize


def test_a_file_that_is_left_out_is_told(tmp_path):
    write(parts.build("wedge"), tmp_path / "wedge.csg")
    (tmp_path / "broken.stl").write_text("garbage")
    rows = ["x,y,z,nx,ny,nz", *(f"{x},{y},0,0,0,1" for x in (0, 5, 10) for y in (0, 4))]
    source = tmp_path / "contacts.txt"
    source.write_text("\n".join(rows))
    answer = recognize(Asked(str(source), sigma=0.1), tmp_path, "auto", 1.0)
    assert any("broken.stl is left out" in warning for warning in answer["warnings"])
    total = answer["unknown"] + sum(c["probability"] for c in answer["candidates"])
    assert np.isclose(total, 1.0, atol=1e-3)
