"""Descriptions of boards, each read when it is asked for: most benches have one or two kinds of them."""

from collections.abc import Iterator, Mapping
from functools import lru_cache

from hil.config import ConfigError, ProfileInfo, profile_from_yaml
from hil.discovery.board_loading import Named
from hil.discovery.board_places import YAML, BoardPlace, BoardPlaces
from hil.vocab.bus import MapKind
from hil.vocab.problem import not_text

_profile = lru_cache(profile_from_yaml)  # by text: a bench of the test kit is made in 1 ms, not in 25


class ProfileInfos(Mapping[str, ProfileInfo]):
    """Descriptions of boards by name, in the order of the names. One that cannot be used is not there, and is
    in ``refused`` of the places once it was asked for. ``maps``: the kind of maps of registers."""

    def __init__(self, found: BoardPlaces, maps: MapKind | None) -> None:
        self._found, self._maps = found, maps
        self._read: dict[str, ProfileInfo | None] = {}

    def __getitem__(self, name: str) -> ProfileInfo:
        if name not in self._read and name in self._found.places:
            self._read[name] = None if name in self._found.refused else self._info(self._found.places[name])
        if (info := self._read.get(name)) is None:
            raise KeyError(name)
        return info

    def __iter__(self) -> Iterator[str]:
        return (name for name in sorted(self._found.places) if name in self)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def parts(self, name: str) -> Named:
        """Names of a board's UARTs and axes. Raises KeyError as for the board."""
        info = self[name]
        return tuple(info.uarts), tuple(info.named_axes)

    def _info(self, place: BoardPlace) -> ProfileInfo | None:
        try:
            text = (place.folder / YAML).read_text()
            return _profile(text, place.folder, place.name, self._maps)
        except ConfigError as error:
            problems = error.problems
        except UnicodeDecodeError as error:
            problems = [not_text(str(place.folder / YAML), error)]
        except OSError as error:
            remedy = "a board is described in this file: hil profile new writes one"
            problems = [place.problem(YAML, error.strerror or "it cannot be read", remedy)]
        self._found.refused[place.name] = problems
        return None
