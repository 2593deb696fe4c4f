"""Which objects of a library one sensor cannot tell apart, and the touches that tell the others."""

from recognition.confusable.pairs import ConfusableConfig, Pair, Separation, confusable

__all__ = ["ConfusableConfig", "Pair", "Separation", "confusable"]
