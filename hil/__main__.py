"""``python -m hil``: the program ``hil``, for an environment whose commands are not in the path.

May import: hil.cli, the standard library.
"""

if __name__ == "__main__":
    from hil.cli.entry import main

    main()
