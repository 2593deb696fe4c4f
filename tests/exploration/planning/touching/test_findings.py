"""How what an exploration may cost is shared."""

from exploration.devices.guard import Cost
from exploration.planning.touching.findings import ExplorerConfig


def test_an_array_before_others_takes_a_share_of_what_is_left_and_leaves_each_some():
    config, cost = ExplorerConfig(max_touches=100, max_minutes=10.0), Cost()
    limits = []
    for _ in range(3):
        own = config.before_others(cost)
        cost = Cost(touches=own.max_touches, seconds=60.0 * own.max_minutes)
        limits.append(own.max_touches)
    assert limits == sorted(set(limits))
    assert limits[-1] < 100
    assert config.before_others(Cost(touches=200)).max_touches == 200  # spent is spent
