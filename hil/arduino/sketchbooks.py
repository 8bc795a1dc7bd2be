"""Sketchbooks of the Arduino IDEs of a user: the folders in which they look for boards of others.

The IDE 2 and arduino-cli keep the place in ``arduino-cli.yaml``, the IDE 1.8 in ``preferences.txt``. An IDE
1.8 with a folder ``portable`` beside its program has both in there.
"""

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path

import yaml

_CLI_FILES = (".arduinoIDE/arduino-cli.yaml", ".arduino15/arduino-cli.yaml")
"""Configurations of the IDE 2 and of arduino-cli, in the user's home."""
_PREFERENCES = "preferences.txt"
_PLACE = "sketchbook.path"
_DEBIANS_IDE = Path("/usr/share/arduino")
_PLACES = (Path("/opt"),)
"""Folders in which IDEs are unpacked, beside the user's home."""


def default_sketchbook(home: Path) -> Path:
    """Sketchbook of every IDE whose settings name no other."""
    return home / "Arduino"


def named_sketchbooks(env: Mapping[str, str], home: Path) -> list[Path]:
    """List the sketchbooks that settings name, those of the IDE 2 and arduino-cli first. Folders that are not
    there are left out, but not one of ``$ARDUINO_DIRECTORIES_USER``."""
    if said := env.get("ARDUINO_DIRECTORIES_USER"):
        found = {Path(said).absolute(): None}
    else:
        found = _present(_of_cli(home))
    return list(found | _present(_of_ide_1_8(home / ".arduino15")) | _present(_of_portable_ides(env, home)))


def find_sketchbooks(option: Path | None, env: Mapping[str, str], home: Path) -> list[Path]:
    """Find the sketchbooks to install into: that of the option alone, or all that settings name, or else
    ``~/Arduino``."""
    if option:
        return [option.absolute()]
    return named_sketchbooks(env, home) or [default_sketchbook(home)]


def _present(folders: Iterator[Path]) -> dict[Path, None]:
    return {folder.absolute(): None for folder in folders if _is_folder(folder)}


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # in a folder of another user's
        return False


def _of_cli(home: Path) -> Iterator[Path]:
    for name in _CLI_FILES:
        with suppress(OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError):
            yield home / str(yaml.safe_load((home / name).read_text())["directories"]["user"])


def _of_ide_1_8(settings: Path) -> Iterator[Path]:
    """Place in the IDE's settings. A relative one is in their folder, which it can be in a portable IDE."""
    with suppress(OSError, UnicodeDecodeError):
        for line in (settings / _PREFERENCES).read_text().splitlines():
            name, _, place = line.partition("=")
            if name.strip() == _PLACE and place.strip():
                yield settings / place.strip()


def _of_portable_ides(env: Mapping[str, str], home: Path) -> Iterator[Path]:
    started = shutil.which("arduino", path=env.get("PATH", os.defpath))
    on_path = [Path(started).resolve().parent] if started else []
    unpacked = [folder for place in (home, *_PLACES) for folder in sorted(place.glob("arduino-1.*"))]
    for folder in (*on_path, _DEBIANS_IDE, *unpacked):
        portable = folder / "portable"
        # Without settings, which it saves at its end, it is there.
        yield from list(_of_ide_1_8(portable)) or [portable / "sketchbook"]
