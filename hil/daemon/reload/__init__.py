"""A reload: a running bench becomes what the configuration says now.

``plan.py`` says what is to be done, ``reload.py`` does it. Imports the boards' store; no other room of the
daemon.
"""
