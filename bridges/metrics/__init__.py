"""Metrics over HTTP, in the text format that Prometheus scrapes.

``exposition.py`` writes the format; ``metrics_bridge.py`` serves ``GET /metrics`` and nothing else.
"""
