from recognition.running.summary import counted


def test_warnings_are_counted_and_not_repeated():
    raw = [f"collision of lts210 by 0.{k} mm" for k in range(4)] + ["a", "pressed to 61.0 N, 1.20 mm", "a"]
    assert counted(raw) == [
        "the housing behind the pad met the object, and backed off (4 times)",
        "a (2 times)",
        "a press passed its limit, and the pad backed off",
    ]
