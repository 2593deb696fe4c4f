"""Boundaries written as JSON and read again."""

import json

import numpy as np
import pytest

from models import parts
from models.boundary import boundary
from models.brep import Brep
from models.brep_json import brep_from_json, load_brep
from models.comparison.canonical import same_boundary
from models.csg import Csg, Cube
from models.solid import Solid
from primitives.errors import PalpateError


def brep_of(tree: Csg) -> Brep:
    return boundary(Solid.from_csg(tree))


def test_a_boundary_survives_its_json() -> None:
    for name in ("cone", "sphere", "d_shaft", "flange", "countersunk_plate", "slotted_block"):
        brep = brep_of(parts.build(name))
        again = brep_from_json(json.loads(json.dumps(brep.as_json())))
        match = same_boundary(brep, again, 1e-6)
        assert match, name
        assert (again.shells, again.genus) == (brep.shells, brep.genus)


@pytest.mark.parametrize(
    "spoiled",
    [
        {},
        [],
        None,
        {"faces": 3},
        {"faces": [], "edges": [{}], "vertices_mm": []},
        {"faces": [], "edges": [], "vertices_mm": [[np.nan, 0, 0]]},
    ],
)
def test_what_is_no_boundary_is_refused_in_one_line(spoiled: object) -> None:
    with pytest.raises(PalpateError) as caught:
        brep_from_json(spoiled)
    assert "\n" not in str(caught.value)


def test_json_that_breaks_an_invariant_is_refused(tmp_path) -> None:
    fields = brep_of(Cube((10, 20, 30))).as_json()
    fields["edges"][3]["vertices"] = [0, 99]
    path = tmp_path / "brep.json"
    path.write_text(json.dumps(fields))
    with pytest.raises(PalpateError, match=r"brep\.json: .*edge 3"):
        load_brep(path)
