"""Reasons why a bench does not start, or is not changed."""


class StartError(Exception):
    """Error of a bench that cannot start: ``str(error)`` says why and what to do, a line for each problem."""


class Refused(Exception):
    """Refusal of a change, after which nothing has changed: ``str(error)`` says why, a line for each
    reason."""


class ConfigUnreadable(Refused):
    """Refusal of a configuration that is not there, or no text: as wrong as one with problems."""
