"""Places of boards: with hil, in packages that are installed beside it, and in folders that a user names."""

from collections.abc import Iterator, Sequence
from dataclasses import field
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

from hil.discovery.installed import BOARDS, NotThere, folder_of, installed, told
from hil.vocab.late_dataclass import dataclass
from hil.vocab.problem import Problem

PROFILES = "device_profiles"
YAML, PYTHON = "profile.yaml", "board.py"
MAKE_ONE = "a board is a folder with profile.yaml and board.py; hil profile new makes one"


@dataclass(frozen=True)
class BoardPlace:
    """Folder of a board, and the name that it is imported by. ``origin`` says for people where it is."""

    name: str
    folder: Path
    package: str
    origin: str

    def problem(self, file: str, message: str, remedy: str, line: int = 1, column: int = 1) -> Problem:
        """Problem in a file of the folder."""
        return Problem(str(self.folder / file), line, column, message, remedy)


@dataclass
class BoardPlaces:
    """Boards that were found, by name. ``wrong_paths`` has a message and a remedy for each folder of boards
    that does not do, by its index."""

    places: dict[str, BoardPlace] = field(default_factory=dict)
    refused: dict[str, list[Problem]] = field(default_factory=dict)
    wrong_paths: dict[int, tuple[str, str]] = field(default_factory=dict)

    def add(self, place: BoardPlace) -> None:
        """Add a board; of two of one name from two places neither can be used."""
        other = self.places.setdefault(place.name, place)
        if other.folder != place.folder:
            message = f"there are two boards {place.name}: {other.origin}, and {place.origin}"
            remedy = "give one of them another name, or leave one place out"
            self.refused[place.name] = [place.problem(YAML, message, remedy)]


def find_places(path: Sequence[Path] = ()) -> BoardPlaces:
    """Find all boards; ``path`` are folders in which there are more. Imports none of them."""
    found = BoardPlaces()
    for place in _with_hil():
        found.add(place)
    for name, points in installed(BOARDS).items():
        for point in points:
            try:
                found.add(BoardPlace(name, folder_of(point), point.value, told(point)))
            except NotThere as error:
                remedy = f'mend the entry point {name} = "{point.value}" of its package'
                found.refused[name] = [Problem(told(point), 0, 0, str(error), remedy)]
    for index, folder in enumerate(path):
        if wrong := _wrong(folder):
            found.wrong_paths[index] = wrong
        for board in _boards_in(folder):
            found.add(BoardPlace(board.name, board, _package_of(board), str(board)))
    return found


def _with_hil() -> Iterator[BoardPlace]:
    spec = find_spec(PROFILES)
    for root in (spec.submodule_search_locations or []) if spec else []:
        for board in _boards_in(Path(root)):
            yield BoardPlace(board.name, board, f"{PROFILES}.{board.name}", f"that of hil, {board}")


def _boards_in(folder: Path) -> list[Path]:
    """Folders that have a board's file, in the order of their names."""
    return sorted({file.parent for name in (YAML, PYTHON) for file in folder.glob(f"*/{name}")})


def _wrong(folder: Path) -> tuple[str, str] | None:
    if not folder.is_dir():
        return f"there is no folder {folder}", "a relative one is looked up from this file's folder"
    if (folder / YAML).exists():
        return f"{folder} is a board itself", f"name the folder it stands in, {folder.parent}"
    return None if _boards_in(folder) else (f"there is no board in {folder}", MAKE_ONE)


def _package_of(folder: Path) -> str:
    """Name a package for a folder as no other folder's is; ``board_loading`` makes it."""
    return f"board_{folder.name}_{sha256(str(folder).encode()).hexdigest()[:12]}"
