import numpy as np
import pytest

from exploration.devices.following import Following
from exploration.devices.guard import Collision, Fault, Guard, GuardLimits
from exploration.devices.protocols import StageEvent
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.physics.housing import housing_box
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3
from primitives.errors import PalpateError

DOWN = np.diag([1.0, -1.0, -1.0])


BLOCK = Cube((40.0, 40.0, 40.0))


def guard_over(start, mount=None, part=BLOCK, **limits) -> Guard:
    stage, arrays = simulate(
        Solid.from_csg(part),
        [load_sensor("lts210")],
        np.random.default_rng(0),
        start_pose=start,
        flange_from_sensor=None if mount is None else [mount],
    )
    return Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)], GuardLimits(**limits))


def keep_moving(guard: Guard, vz: float) -> None:
    for _ in range(400):
        guard.move(np.array([0.0, 0.0, vz, 0.0, 0.0, 0.0]))


def test_pressing_on_is_stopped_and_backed_off():
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 22.0]))
    with pytest.raises(Fault, match=r"lts210|pressed"):
        keep_moving(guard, 10.0)
    assert guard.world_from_sensor[2, 3] > 20.0  # off the surface again


class LockedOnTheWayBack:
    """A stage that trips on its first leg back, and refuses every motion until it has been stopped."""

    def __init__(self, stage):
        self._stage, self._legs, self._locked, self._untold = stage, 0, False, False

    def __getattr__(self, name):
        return getattr(self._stage, name)

    @property
    def moving(self):
        return not self._locked and self._stage.moving

    def go_to(self, pose):
        self._legs += 1
        if self._legs == 1:
            self._locked = self._untold = True
        if not self._locked:
            self._stage.go_to(pose)

    def stop(self):
        self._locked = False
        self._stage.stop()

    def events(self):
        told, self._untold = self._untold, False
        return self._stage.events() + (StageEvent("overpress", 0.0, 0.0, "a limit"),) * told


def test_a_limit_passed_on_the_way_back_does_not_lock_the_stage():
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 22.0]))
    guard.stage = LockedOnTheWayBack(guard.stage)
    with pytest.raises(Fault):
        keep_moving(guard, 10.0)
    guard.go_to(se3.pose(DOWN, [0.0, 0.0, 60.0]))
    assert guard.world_from_sensor[2, 3] == pytest.approx(60.0, abs=0.1)


def test_backing_off_ends_in_the_open_where_there_is_no_room_behind():
    low, high = housing_box(load_sensor("lts210"))
    ceiling = 20.0 + 2.0 + float(high[2] - low[2]) + 3.0
    jaws = Cube((40.0, 40.0, 40.0)) | Cube((40.0, 40.0, 10.0)).at(0.0, 0.0, ceiling + 5.0)
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 22.0]), part=jaws)
    for _ in range(3):
        with pytest.raises(Fault):
            keep_moving(guard, 10.0)
        guard.hold()  # a housing left in the jaw would be told of again


def test_the_housing_meeting_the_object_is_a_collision():
    guard = guard_over(se3.pose(np.eye(3), [0.0, 0.0, 65.0]))  # the pad looks away, its housing comes down
    for _ in range(2):  # the second time it has not come far
        with pytest.raises(Collision):
            keep_moving(guard, -20.0)
        assert guard.world_from_sensor[2, 3] + housing_box(guard.sensor.spec)[0][2] > 20.0  # above it again


def test_leaving_the_reach_is_refused_in_one_line():
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 80.0]), reach=(-50.0, -50.0, -50.0, 50.0, 50.0, 90.0))
    with pytest.raises(PalpateError, match="reach"):
        keep_moving(guard, -20.0)


def test_costs_add_up():
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 80.0]))
    guard.go_to(se3.pose(DOWN, [30.0, 0.0, 80.0]))
    assert guard.cost.travel == pytest.approx(30.0, abs=0.3)
    assert guard.cost.seconds == pytest.approx((guard.cost.frames - 1) * guard.period, rel=1e-6)


def test_a_sensor_twist_moves_the_sensor_however_it_is_mounted():
    mount = se3.pose(se3.rotation_exp([0.3, -1.0, 0.5]), [20.0, -40.0, 60.0])
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 200.0]) @ se3.inverse(mount), mount)
    before = guard.world_from_sensor
    for _ in range(200):
        guard.move(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.4]))
    np.testing.assert_allclose(guard.world_from_sensor[:3, 3], before[:3, 3], atol=0.5)
    assert guard.world_from_sensor[:3, 0] @ before[:3, 0] < np.cos(0.3)


def test_frames_read_while_backing_off_are_counted_and_shown():
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 22.0]))
    shown = []
    guard.observers = (shown.append,)
    with pytest.raises(Fault):
        keep_moving(guard, 10.0)
    assert shown[-1].world_from_sensor[2, 3] > shown[-2].world_from_sensor[2, 3] - 1e-9
    assert shown[-1].world_from_sensor[2, 3] > 20.0
    assert guard.cost.frames == len(shown)


def test_a_fault_tells_the_way_that_the_array_came_as_it_was_and_not_the_way_back():
    guard = guard_over(se3.pose(np.eye(3), [0.0, 0.0, 80.0]))
    went = [guard.hold().world_from_sensor[2, 3]]
    guard.observers = (lambda seen: went.append(seen.world_from_sensor[2, 3]),)
    with pytest.raises(Collision) as told:
        keep_moving(guard, -20.0)
    heights = np.array([pose[2, 3] for pose in told.value.came])
    assert heights[0] == pytest.approx(min(went), abs=0.5)
    assert heights[-1] > heights[0] + 5.0
    assert (np.diff(heights) >= -1e-9).all()


def test_nobody_learns_from_a_frame_that_passed_a_limit():
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 22.0]))
    shown, learned = [], []
    guard.observers, guard.learners = (shown.append,), (learned.append,)
    with pytest.raises(Fault):
        keep_moving(guard, 10.0)
    assert 0 < len(learned) < len(shown)
    assert all(seen.image.depth.max() < guard.limits.depth for seen in learned)


def test_a_stage_that_stands_still_is_told_of_and_one_that_follows_is_not() -> None:
    here, twist = np.eye(4), np.array([0.0, 0.0, 20.0, 0.0, 0.0, 0.0])
    stuck = Following()
    assert any(stuck.stands(here, twist, 0.005, 0.02) for _ in range(100))
    late, follows = [np.eye(4)] * 30, Following()
    for _ in range(400):
        late.append(late[-1] @ se3.pose(translation=0.005 * twist[:3]))
        assert not follows.stands(late[-30], twist, 0.005, 0.1)


def test_a_stage_that_a_watchdog_holds_is_not_taken_for_one_that_stands():
    guard = guard_over(se3.pose(DOWN, [0.0, 0.0, 60.0]))
    moving, held = guard.stage, []

    class Held:
        def __getattr__(self, name):
            return getattr(moving, name)

        def move(self, twist):
            moving.move(np.zeros(6))

        held = property(lambda self: held[0])

    guard.stage, held[:] = Held(), [True]
    keep_moving(guard, 20.0)
    held[:] = [False]
    with pytest.raises(Fault, match="stands still"):
        keep_moving(guard, 20.0)
