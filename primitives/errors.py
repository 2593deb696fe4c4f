"""The one root of every error that Palpate raises on purpose."""


class PalpateError(Exception):
    """Broken input or a broken device; the message is one line and names the fix."""


class NotWritten(PalpateError):
    """A result could not be written where it should go: no more of the work can be kept."""
