"""Real drives of a bench as devices and as axes of runs, whatever bus they are on.

Without I/O: ``drive_link.py`` says when one is there, ``reading.py`` what it told, ``arrival.py`` when it has
come to its target, ``drive_fields.py`` what doors see of it, ``drive_verbs.py`` what can be asked of it.

With I/O: ``real_drive.py`` is a drive, ``drive_motion.py`` moves it, ``drive_control.py`` has its verbs,
``drive_axis.py`` is the drive as an axis of runs; ``shared_lines.py`` has the lines of all,
``drive_errors.py`` the errors. Each bus has its own kind of each.

May import: hil.core, hil.firmware, hil.runs, hil.vocab, hil.wire, the standard library.
"""
