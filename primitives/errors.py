"""The one root of every error that Palpate raises on purpose."""


class PalpateError(Exception):
    """Broken input or a broken device; the message is one line and names the fix."""
