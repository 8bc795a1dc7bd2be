"""Models of a bench with the keys of the kinds of buses that are there."""

from collections.abc import Mapping
from copy import copy
from functools import lru_cache
from typing import Annotated, Any

from pydantic import BaseModel, Field, create_model

from hil.config.explain import LazyModel
from hil.config.model import BenchConfig, DeviceConfig
from hil.config.port_model import Name
from hil.vocab.bus import BusKind


def device_model(buses: tuple[BusKind, ...]) -> type[DeviceConfig]:
    """Make the model with the keys that these kinds of buses have for a device."""
    keys: dict[str, Any] = {}
    for maps in (bus.maps for bus in buses if bus.maps):
        keys["map"] = (
            Annotated[Any, LazyModel(maps.model)] | None,
            Field(default=None, description=maps.about),
        )
    drives = [bus.drives for bus in buses if bus.drives]
    for name, key in (pair for kind in drives for pair in kind.keys.items()):
        keys[name] = Annotated[Any, LazyModel(key.model)] | None, Field(default=None, description=key.about)
    at = copy(DeviceConfig.model_fields["at"])
    at.description = "".join((str(at.description), *(kind.about for kind in drives)))
    return create_model(
        "DeviceConfig", __base__=DeviceConfig, __module__=BenchConfig.__module__, at=(str | None, at), **keys
    )


@lru_cache
def bench_model(buses: tuple[BusKind, ...]) -> type[BenchConfig]:
    """Make the model with the keys of these kinds of buses, in a bench, in a segment and in a device."""

    def segment() -> type[BaseModel]:
        from hil.config.segment_model import segment_model

        return segment_model(buses)

    own, kinds = BenchConfig.model_fields, [bus.wires for bus in buses if bus.wires]
    keys: dict[str, Any] = {
        kind.key: (
            Mapping[Name, Annotated[Any, LazyModel(kind.model)]],
            Field(default={}, description=kind.about),
        )
        for kind in kinds
    }
    keys["devices"] = Mapping[Name, device_model(buses)], copy(own["devices"])  # type: ignore[misc]
    keys["segments"] = Mapping[Name, Annotated[Any, LazyModel(segment)]], copy(own["segments"])
    made = create_model("BenchConfig", __base__=BenchConfig, __module__=BenchConfig.__module__, **keys)
    made.bus_keys = (*BenchConfig.bus_keys, *(kind.key for kind in kinds))
    return made
