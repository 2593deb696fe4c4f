"""Touching as reinforcement learning sees it: Gymnasium environments, and our planners to compare with.

    import gymnasium, recognition.environments
    env = gymnasium.make("palpate/Identify-v0")

Importing this package registers `palpate/Identify-v0` and `palpate/Explore-v0`; it needs the extra `gym`.
"""

from primitives.errors import PalpateError

try:
    import gymnasium
except ImportError:
    raise PalpateError('environments need gymnasium: pip install "palpate[gym]"') from None

for _name, _entry in (
    ("palpate/Identify-v0", "recognition.environments.identify:IdentifyEnv"),
    ("palpate/Explore-v0", "recognition.environments.explore:ExploreEnv"),
):
    if _name not in gymnasium.registry:
        gymnasium.register(_name, entry_point=_entry)
