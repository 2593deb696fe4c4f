from models.library import Built
from recognition.libraries.answers import built_text


def test_of_many_warnings_a_person_is_told_some():
    built = Built((), (), (), {}, tuple(f"{k}.stl had 1 hole" for k in range(30)), (), 0)
    lines = built_text(built).splitlines()
    assert lines[1] == "warning: 0.stl had 1 hole"
    assert lines[-1] == "and 10 warnings more (--json has all)"
    assert len(lines) == 22
