"""Commands that look at the benches of a lab from any computer, over zenoh.

``lab_options.py`` has the options that say where, ``benches_command.py`` lists the benches there,
``site_stop_view.py`` stops what moves on all of them, ``prometheus_targets.py`` makes them targets of
Prometheus.

May import: hil.cli.framework, hil.cli.runs, hil.client, hil.host, hil.net, hil.vocab, hil.wire,
the standard library, typer.
"""
