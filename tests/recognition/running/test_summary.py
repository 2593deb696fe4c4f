from recognition.running.summary import counted


def test_warnings_are_counted_and_not_repeated():
    raw = [f"collision of lts210 by 0.{k} mm" for k in range(4)] + ["a", "pressed to 61.0 N, 1.20 mm", "a"]
    assert counted(raw) == [
        "the housing met the object (4 times)",
        "a (2 times)",
        "the press passed its limit",
    ]
