from collections import Counter
from functools import cache

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from models import parts
from models.part import load_part
from models.solid import Solid
from primitives.errors import PalpateError


@cache
def _solid(name: str) -> Solid:
    return Solid.from_csg(parts.build(name), tolerance=0.02)


def test_there_are_forty_parts_or_more() -> None:
    assert len(parts.names()) >= 40
    assert {"block", "cylinder", "cone", "frustum", "sphere", "d_shaft", "bracket"} <= set(parts.names())


@pytest.mark.parametrize("name", parts.names())
def test_a_part_is_as_large_as_its_line_says(name: str) -> None:
    line = parts.describe(name)
    extent = _solid(name).extent
    assert 20 <= extent.max() <= 200
    np.testing.assert_allclose(extent, line.extent, atol=0.06)
    assert line.description


@pytest.mark.parametrize("name", parts.names())
def test_convex_parts_fill_their_hull_and_no_others_do(name: str) -> None:
    solid = _solid(name)
    fills = ConvexHull(solid.vertices).volume < 1.001 * solid.volume
    assert fills == parts.describe(name).convex


@pytest.mark.parametrize("name", parts.names())
def test_a_part_is_one_solid_of_one_piece(name: str) -> None:
    assert len(_solid(name).body.mesh.decompose()) == 1


def test_no_two_parts_are_the_same_solid() -> None:
    sizes = {(_solid(name).volume, _solid(name).area) for name in parts.names()}
    assert len(sizes) == len(parts.names())


@pytest.mark.parametrize(
    ("name", "twin"),
    [
        ("bracket", "bracket_one_hole"),
        ("bolt_plate", "bolt_plate_one_wider"),
        ("bearing_block", "bearing_block_wide_bore"),
        ("stepped_shaft", "stepped_shaft_thick"),
        ("flange", "flange_three_holes"),
    ],
)
def test_twins_differ_in_one_primitive_only(name: str, twin: str) -> None:
    first, second = (
        Counter((leaf.primitive, leaf.part_from_primitive.tobytes()) for leaf in parts.build(n).leaves())
        for n in (name, twin)
    )
    assert max((first - second).total(), (second - first).total()) == 1


def test_a_misspelled_part_suggests_the_right_one() -> None:
    with pytest.raises(PalpateError, match="no part 'brackett'; did you mean bracket"):
        load_part("brackett")


def test_a_built_in_part_keeps_its_tree() -> None:
    part = load_part("block")
    assert part.csg == parts.build("block")
    assert part.solid.volume == pytest.approx(60 * 40 * 12)


def test_a_part_may_be_scaled() -> None:
    np.testing.assert_allclose(
        load_part("bracket", scale=0.93).solid.extent, 0.93 * _solid("bracket").extent, atol=0.01
    )
    tree = load_part("bracket", scale=0.93).csg
    assert tree is not None
    assert [leaf.primitive.name for leaf in tree.leaves()] == [
        leaf.primitive.name for leaf in parts.build("bracket").leaves()
    ]
