"""Shipped checks: the rules for all codecs, ports and bridges.

Each check tries what its docstring lists, collects all that is wrong, and raises ``CheckFailed``; each line
of it begins with the word for what is not kept to.
"""
