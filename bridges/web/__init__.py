"""The web bridge: a page in the browser, over HTTP and one WebSocket for each page.

``web_options.py`` has the options, ``web_users.py`` and ``password_hash.py`` read who may come in.
``http_door.py`` answers HTTP: it checks names and users (``locks.py``, ``login_sessions.py``), and gives the
page's files (``page_files.py``). ``open_pages.py`` has the pages and their connections, whose frames
``websocket_frames.py`` checks; ``web_client.py`` is one page's WebSocket: ``web_messages.py`` reads what it
asks, ``bench_words.py`` tells it of the bench in rows of ``page_rows.py``. ``outbox.py`` has what waits for
it, ``streams.py`` and its neighbours what it watches, ``web_terminals.py`` its terminals.

May import: hil.net, hil.vocab, hil.wire, the standard library, any package.
"""
