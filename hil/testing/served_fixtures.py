"""Fixtures of benches in real time: ``live_bench`` and ``real_bench``."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from hil.testing.kind_account import REAL_BOARDS, kind_of
from hil.testing.unsupported import UnsupportedHere

if TYPE_CHECKING:
    from hil.testing.given import GivenConfig
    from hil.testing.served_bench import ServedBench


@pytest.fixture
def live_bench(tmp_path: Path) -> "Iterator[Callable[..., ServedBench]]":
    """Run benches in processes of their own, in real time, until the test's end: ``live_bench("bench.yaml")``
    answers when its boards do. Options as of ``hil.testing.live``. Logs and captures stay in ``tmp_path``."""
    from hil.testing.serving import live

    yield from _made(live, tmp_path / "live_bench")


@pytest.fixture
def real_bench(request: pytest.FixtureRequest, tmp_path: Path) -> "Iterator[Callable[..., ServedBench]]":
    """Reach the real boards that ``--hil=FILE`` names: ``real_bench("bench.yaml")``, for a test that was
    written for this configuration, or ``real_bench()``. Without ``--hil=FILE`` the configuration itself has
    to say where its boards are (``at:``), or the test is skipped."""

    def serve(config: "GivenConfig | None" = None, **options: Any) -> "AbstractContextManager[ServedBench]":
        __tracebackhide__ = True
        from hil.testing.config_reading import read_config
        from hil.testing.given import path_of
        from hil.testing.real_boards import RealBoards

        boards: RealBoards | None = request.config.stash.get(REAL_BOARDS, None)
        if boards:
            return boards.serve(config, **options)
        path = None if config is None else path_of(config)
        if path and read_config(path)[0].real:
            return RealBoards(path).serve(**options)
        why = "pytest --hil=FILE.yaml says where the real boards are"
        raise UnsupportedHere(kind_of(request.config), why)

    yield from _made(serve, tmp_path / "real_bench")


def _made(
    serve: "Callable[..., AbstractContextManager[ServedBench]]", keep: Path
) -> "Iterator[Callable[..., ServedBench]]":
    """Answer a function that makes benches, which end with the test. ``keep``: beginning of the names of the
    folders in which their logs and captures stay."""
    from hil.config import ConfigError
    from hil.testing.given import path_of
    from hil.testing.live_desk import LiveError

    with ExitStack() as stack:
        number = 0

        def run(*config: "GivenConfig", **options: Any) -> "ServedBench":
            __tracebackhide__ = True
            nonlocal number
            for each in config:
                path_of(each)  # refused here, without the frames of contexts
            number += 1
            folder = keep.with_name(f"{keep.name}{number}")
            try:
                return stack.enter_context(serve(*config, **{"keep": folder} | options))
            except (ConfigError, LiveError, UnsupportedHere) as error:
                raise error.with_traceback(None) from None

        yield run
