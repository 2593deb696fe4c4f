"""Matching of what touch gave to the objects of a library: `match(evidence, library) -> Belief`."""

from recognition.matching.belief import Belief, Hypothesis
from recognition.matching.evidence import Evidence, Prior
from recognition.matching.match import MatchConfig, match

__all__ = ["Belief", "Evidence", "Hypothesis", "MatchConfig", "Prior", "match"]
