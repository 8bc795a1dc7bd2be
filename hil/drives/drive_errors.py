"""Errors of what a real drive is asked, whatever it is asked over."""

URGENT, IN_TURN = 0, 1
"""Orders of requests: verbs before set-points and polls, which take turns."""


class PlaceLost(Exception):
    """Loss of the place; ``str(error)`` says why. What was asked may have been done, or not."""


class NoAnswer(Exception):
    """End of the time for an answer."""


class Garbled(Exception):
    """Answer that does not fit its request."""


class Denied(Exception):
    """Answer that says why the drive does not do what it was asked."""


class Stale(Exception):
    """Request that was not sent, as nobody wants it any more: the drive was lost meanwhile."""


ASKING = (PlaceLost, NoAnswer, Garbled, Denied, Stale)
"""Errors of a request."""
