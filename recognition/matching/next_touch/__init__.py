"""Where to touch next: candidates, what each would feel under each hypothesis, and what that is worth."""

from recognition.matching.next_touch.choose import Choice, NoChoice, choose, separating

__all__ = ["Choice", "NoChoice", "choose", "separating"]
