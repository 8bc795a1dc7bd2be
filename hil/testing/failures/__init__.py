"""Accounts of tests that failed: where a bench in memory stands, what has passed on its ports and wires, and
files of both for who looks later.

A passing test pays for none of it: ``bench_traffic.py`` reads the inputs that a bench keeps, and
``bench_replay.py`` runs them again with somebody who listens at the wires and samples the axes.
``bench_account.py`` has the sections of a report, ``failure_folder.py`` the files, ``failure_page.py`` one of
them, the page.

May import: hil.compose, hil.config, hil.core, hil.discovery, hil.sim, hil.telemetry, hil.testing, hil.vocab,
hil.wire, the standard library.
"""
