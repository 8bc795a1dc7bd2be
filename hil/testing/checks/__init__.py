"""Shipped checks: what every codec, port and bridge has to keep to, whoever wrote it.

Each check tries what its docstring lists, collects all that is wrong, and raises ``CheckFailed``; each line
of it begins with the word for what is not kept to.
"""
