"""What is asked of the daemon itself."""

import os
from collections.abc import Callable, Mapping
from typing import Any

from hil.config import ConfigError
from hil.live.refusals import ConfigUnreadable, Refused
from hil.live.reload import Reloader
from hil.operations.desk import Answerer, Asked
from hil.vocab.verbs import VerbRefused


class DaemonOperations:
    """``stop``: ends the daemon soon."""

    def __init__(self, apply: Reloader, stop: Callable[[], None]) -> None:
        self._apply, self._stop = apply, stop

    def answers(self) -> Mapping[str, Answerer]:
        return {"reload": self.reload, "stop": self.stop}

    async def reload(self, asked: Asked) -> dict[str, Any]:
        """Names of devices that were kept, restarted, added and removed."""
        try:
            return await self._apply.reload()
        except (ConfigError, ConfigUnreadable) as error:
            raise VerbRefused("bad_config", str(error)) from None
        except Refused as error:
            raise VerbRefused("not_now", str(error)) from None

    def stop(self, asked: Asked) -> dict[str, int]:
        """The process that ends."""
        self._stop()
        return {"pid": os.getpid()}
