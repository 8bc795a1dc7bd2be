"""Reasons why a bench does not start, or is not changed."""


class StartError(Exception):
    """The bench cannot start: ``str(error)`` says why and what to do, a line for each problem."""


class Refused(Exception):
    """A change was refused, and nothing has changed: ``str(error)`` says why, a line for each reason."""


class ConfigUnreadable(Refused):
    """The configuration is not there, or no text: as wrong as one with problems."""
