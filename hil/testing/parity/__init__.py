"""Parity: a dialogue that is typed at a board and at its twin, and how far their answers are the same.

``typed_session.py`` is the file; ``step_player.py`` types it, at whatever plays a dialogue;
``twin_player.py`` has the twin's side, in virtual time. ``answer_match.py`` compares two answers,
``parity_scores.py`` two recordings. None of them has a clock or a port of the system.

May import: hil.compose, hil.config, hil.testing.bench, hil.vocab, the standard library, pydantic.

Tests may import too: device_profiles, hil.testing.
"""
