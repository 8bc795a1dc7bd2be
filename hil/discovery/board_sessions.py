"""Sessions that boards have: files in a folder of each board's own."""

from pathlib import Path

from hil.discovery.board_places import BoardPlaces

SESSIONS = "sessions"


def shipped_sessions(places: BoardPlaces) -> dict[str, Path]:
    """Files of all boards' sessions, by the board's name and their own, as ``sac/identify``."""
    return {
        f"{name}/{file.stem}": file
        for name, place in sorted(places.places.items())
        for file in sorted((place.folder / SESSIONS).glob("*.json"))
    }
