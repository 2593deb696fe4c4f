"""The touch that tells most of where an object is that was named."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exploration.planning.touching.lone_touch import Approach, LoneTouch
from exploration.planning.ways.round_ball import Ball
from models.library import Library
from primitives.evidence import Contacts
from recognition.identifying.exact import Exact
from recognition.identifying.hand import Hand
from recognition.matching import Hypothesis
from recognition.matching.next_touch.flight import flown, least_turned
from recognition.matching.next_touch.held import Held
from recognition.matching.next_touch.placing import placing


def finish(
    h: Hypothesis,
    errs: Exact | None,
    touches: Sequence[LoneTouch],
    felt: Contacts,
    known: Held | None,
    library: Library,
    hand: Hand,
    ball: Ball,
    rng: np.random.Generator,
) -> Approach | None:
    """From outside the ball, flown as far as what is `known` lets it be; None where nothing can be felt.

    Touches err as was estimated of those before, or as their contacts say where it was not.
    """
    usual = float(np.median(felt.sigma)), float(np.median(felt.normal_sigma))
    noise = usual if errs is None else (errs.place, errs.turn)
    skin = next((t.imprint for t in reversed(touches) if t.imprint is not None), None)
    found = placing(h, library[h.name], ball, hand.pad, noise, rng, hand.reachable, skin=skin)
    if found is None or known is None:
        return found
    return flown(least_turned(found, hand.here), known, library, hand.pad)
