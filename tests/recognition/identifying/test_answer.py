import pytest

from recognition.identifying.answer import of_pose, of_search


def candidate(place: float, turn: float) -> dict[str, object]:
    return {"pose_sigma": {"translation_mm": place, "rotation_deg": turn}}


@pytest.mark.parametrize(("place", "turn"), [(0.9, 0.3), (0.05, 8.0)])
def test_a_name_that_is_sure_without_its_pose_says_so(place: float, turn: float) -> None:
    (told,) = of_pose("sure", [candidate(place, turn), candidate(0.01, 0.1)])
    assert f"{place:.2g} mm and {turn:.2g} degrees" in told


def test_a_pose_that_is_known_and_one_that_nobody_is_sure_of_say_nothing() -> None:
    assert of_pose("sure", [candidate(0.05, 0.3)]) == []
    assert of_pose("budget", [candidate(0.9, 8.0)]) == []
    assert of_pose("sure", [{"pose_sigma": None}]) == []
    assert of_pose("sure", []) == []


def test_touches_that_went_into_the_search_are_told_where_it_did_not_become_sure():
    (told,) = of_search("budget", [False] * 30 + [True, False, True])
    assert told.startswith("30 of 33 touches met nothing")
    assert of_search("nothing was found in the workspace", [False] * 4) != []
    assert of_search("sure", [False] * 30 + [True] * 3) == []
    assert of_search("budget", [False, True] + [True] * 8) == []
    assert of_search("nothing was found in the workspace", []) == []
