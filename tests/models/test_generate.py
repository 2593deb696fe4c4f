from collections import Counter

import numpy as np
import pytest

from models.boundary import boundary
from models.csg import Csg
from models.generate import generate
from models.solid import Solid
from primitives.errors import PalpateError


def _part(seed: int) -> Csg:
    return generate(np.random.default_rng(seed), complexity=seed % 7)


def _sound(seed: int) -> Counter[str]:
    """The kinds of a part's faces, once all that the generator promises has been found true of it."""
    solid = Solid.from_csg(_part(seed), tolerance=0.02)
    brep = boundary(solid)
    assert brep.check() == (), seed
    assert brep.shells == 1, seed
    assert len(solid.body.mesh.decompose()) == 1, seed
    assert 20 <= solid.extent.max() <= 200, seed
    assert min(min(face.extent) for face in brep.faces if face.kind == "plane") >= 1.99, seed
    return Counter(face.kind for face in brep.faces)


def test_generated_parts_are_sound_and_show_every_shape() -> None:
    kinds = sum((_sound(seed) for seed in range(40)), Counter())
    assert set(kinds) == {"plane", "cylinder", "cone", "sphere", "torus"}


@pytest.mark.slow
def test_forty_more_generated_parts_are_sound() -> None:
    for seed in range(40, 80):
        _sound(seed)


def test_a_seed_gives_the_same_part_again_and_another_seed_another() -> None:
    assert _part(5) == _part(5)
    assert len({repr(_part(seed)) for seed in range(60)}) == 60


def test_more_features_make_more_primitives() -> None:
    def leaves(complexity: int) -> int:
        return sum(len(list(generate(np.random.default_rng(s), complexity).leaves())) for s in range(30))

    assert leaves(0) < leaves(2) < leaves(8)


def test_repr_of_a_generated_part_builds_it_again() -> None:
    from models import csg

    for seed in range(20):
        assert eval(repr(_part(seed)), vars(csg)) == _part(seed)


def test_fewer_than_no_features_are_refused() -> None:
    with pytest.raises(PalpateError, match="-1"):
        generate(np.random.default_rng(0), complexity=-1)
