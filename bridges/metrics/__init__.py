"""Metrics over HTTP, in the text format that Prometheus scrapes.

``metrics_bridge.py`` writes the format and serves ``GET /metrics`` and nothing else.
"""
