"""Real TMCL modules as axes of a bench: ``tmcl_drive_address.py`` reads an address, ``tmcl_line.py`` is the
serial line that modules share, ``tmcl_drive.py`` asks one, ``tmcl_motion.py`` moves it, ``tmcl_control.py``
has its verbs.
"""
