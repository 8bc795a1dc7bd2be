"""Recorded runs as files of other programs: tables, MCAP, VCD, captures, pictures.

``export_formats.py`` is the table of formats, ``export_names.py`` finds what somebody wants. One module
for each format writes it piece by piece, as the run goes on: ``csv_table.py``, ``mcap_export.py`` with
``mcap_chunks.py``, ``vcd_export.py``, ``capture_export.py``, ``drawn_export.py``. ``signal_sources.py`` has
levels of pins and lines with their exact times, ``run_records.py`` what passed at ports and on wires.

May import: hil.compose, hil.config, hil.core, hil.recorded, hil.sim, hil.telemetry, hil.vocab, hil.wire,
the standard library, mcap, vcd, zstandard.

Tests may import too: hil.host, hil.testing.
"""
