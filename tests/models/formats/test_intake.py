import pytest

from models.formats import intake, openscad
from models.formats.load import READERS
from primitives.errors import PalpateError


def test_every_suffix_that_has_a_reader_is_known_before_one_is_loaded():
    assert sorted(intake.SUFFIXES) == sorted((*READERS, *openscad.SUFFIXES))


@pytest.mark.parametrize("name", ["a.stl", "a.step", "a.png", "a"])
def test_a_glance_refuses_what_is_no_such_file(name, tmp_path):
    (tmp_path / name).write_bytes(b"\x89PNG" + bytes(30))
    with pytest.raises(PalpateError, match=f"{name} |{name}:"):
        intake.glance(tmp_path / name)
