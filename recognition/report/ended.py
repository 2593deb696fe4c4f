"""Why a run ended, as a person would say it; `ended` of its summary in words that need no explanation."""

_WORDS = {
    "budget": "its time, or the touches that it may make, or make in vain, are used up",
    "nothing reachable is open": "what is still open is out of the pad's reach",
}


def ended_words(ended: str) -> str:
    """The reason; one that already is a sentence of its own stays as it is."""
    return _WORDS.get(ended, ended)
