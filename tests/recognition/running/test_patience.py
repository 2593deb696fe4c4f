"""Patience ends what goes round in circles, and nothing that still learns."""

from recognition.running.patience import Patience, PatienceConfig

TEN = PatienceConfig(touches=10)


def test_a_run_that_finds_faces_or_closes_things_is_never_lost():
    finding, closing = Patience(TEN), Patience(TEN)
    for k in range(33):
        assert not finding.lost(10 * k, k, 100)
        assert not closing.lost(k, 3, 100 - 3 * k)


def test_a_run_in_which_open_things_come_and_go_is_lost():
    patience = Patience(TEN)
    lost = [patience.lost(touches, 6, 20 + touches % 3) for touches in range(40)]
    assert lost.index(True) in range(10, 15)


def test_a_run_that_gives_up_open_things_one_by_one_is_lost():
    patience = Patience(TEN)
    assert any(patience.lost(touches, 6, 200 - touches) for touches in range(40))


def test_a_new_face_renews_it():
    patience = Patience(TEN)
    patience.lost(0, 1, 5)
    assert not patience.lost(10, 1, 5)
    assert not patience.lost(11, 2, 9)
    assert not patience.lost(20, 2, 9)
    assert patience.lost(22, 2, 9)
