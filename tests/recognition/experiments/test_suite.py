"""Suite files: what they become, and what they refuse."""

import pytest

from primitives.errors import PalpateError
from recognition.experiments.suite import load_suite


def suite(tmp_path, text):
    path = tmp_path / "some.toml"
    path.write_text(text)
    return load_suite(path)


def test_lists_are_axes_and_the_seed_turns_fastest(tmp_path):
    made = suite(tmp_path, '[[trials]]\nkind="explore"\nseeds=2\npart=["block","disc"]\nnoise=[0, 0.1]\n')
    told = [(t.settings["part"], t.settings["noise"], t.settings["seed"]) for t in made.trials]
    assert told == [(p, n, s) for p in ("block", "disc") for n in (0.0, 0.1) for s in (0, 1)]
    assert [t.number for t in made.trials] == list(range(8))
    assert set(made.groups[0].axes) == {"part", "noise", "seed"}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('polcy=1\n[[trials]]\nkind="frames"', "unknown key 'polcy'.*valid keys: name"),
        ('[[trials]]\nkind="frames"\nnoize=0.1', "did you mean noise.*valid keys: .*scene"),
        ('[[trials]]\nkind="frame"', "unknown kind 'frame'; it may be explore"),
        ('[[trials]]\nkind="explore"', "needs 'part'"),
        ('[[trials]]\nkind="frames"\nnoise=-1', "0 or more"),
        ('[[trials]]\nkind="frames"\ncount=1.5', "whole number"),
        ('[[trials]]\nkind="frames"\nscene="edges"', "may be edge, corner"),
        ('[[trials]]\nkind="frames"\nnoise=[]', "empty list"),
        ('[[trials]]\nkind="frames"\nseed=1\nseeds=2', "both seed and seeds"),
        ('[limits]\nsecond=1\n[[trials]]\nkind="frames"', "did you mean seconds"),
        ("name='x'", "tries nothing"),
        ("name=", "not valid TOML"),
        ('[[trials]]\nkind="explore"\npart="@conv"', "may be @convex"),
        ('[[trials]]\nkind="explore"\npart="*.stl"', "no file"),
        ('[[trials]]\nkind="explore"\npart="**.stl"', "no file"),
        ('[[trials]]\nkind="explore"\npart="/nowhere/*.stl"', "no file"),
        ('[[trials]]\nkind="explore"\npart="a\\u0000*"', "plain text"),
        ('[[trials]]\nkind=["explore"]', "unknown kind"),
        ('[[trials]]\nkind="explore"\npart="blok"', "no part 'blok'; did you mean block"),
        ('[[trials]]\nkind="explore"\npart="missing.stl"', "no file missing.stl"),
        ('[[trials]]\nkind="explore"\npart="block"\nsensor="lts211"', "did you mean lts210"),
        ('[[trials]]\nkind="recognize"\npart="block"\nlibrary="missing"', "no folder missing"),
        ('[[trials]]\nkind="frames"\nnoise=inf', "finite"),
        ('[[trials]]\nkind="frames"\nseed=9223372036854775808', "finite"),
        ('[[trials]]\nkind="frames"\nseeds=1000000000', "more than the 1000000 trials"),
        ('[limits]\nseconds=0\n[[trials]]\nkind="frames"', "0.001"),
        ('[limits]\nseconds=1e300\n[[trials]]\nkind="frames"', "between"),
        *(
            (f'name="{name}"\n[[trials]]\nkind="frames"', "plain file name")
            for name in ("../../evil", "", "/tmp/x", "..")
        ),
    ],
)
def test_what_is_wrong_is_said_with_what_would_be_right(tmp_path, text, said):
    with pytest.raises(PalpateError, match=said) as error:
        suite(tmp_path, text)
    assert "\n" not in str(error.value)


def test_patterns_are_relative_to_the_suite_or_absolute(tmp_path):
    for name in ("a.stl", "b.stl"):
        (tmp_path / name).touch()
    for pattern, first in (("*.stl", "a.stl"), (f"{tmp_path}/*.stl", f"{tmp_path}/a.stl")):
        made = suite(tmp_path, f'[[trials]]\nkind="explore"\npart="{pattern}"')
        assert len(made.trials) == 2
        assert made.trials[0].settings["part"] == first


def test_the_columns_are_those_of_the_kinds_whatever_the_trials_tell(tmp_path):
    made = suite(tmp_path, '[[trials]]\nkind="frames"\n[[trials]]\nkind="track"\npart="disc"\n')
    assert {"scene", "part", "found_share", "track_rms_mm", "outcome"} <= set(made.columns)
    assert "policy" not in made.columns


def test_every_ready_suite_loads():
    from pathlib import Path

    suites = sorted((Path(__file__).parents[3] / "docs" / "suites").glob("*.toml"))
    assert [len(load_suite(path).trials) > 0 for path in suites] == [True] * len(suites)
