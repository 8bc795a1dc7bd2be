"""Errors of a build."""


class BuildFailed(Exception):
    """Error of a sketch that cannot be built: ``str(error)`` has the compiler's own words, with file and
    line, or says what is wrong with the folder."""


class NoToolchain(BuildFailed):
    """Error of a build for which something has to be installed: ``str(error)`` says which package."""
