"""The codec of ``docs/how-to/write-a-test.md`` passes its check, as it stands there."""

from typing import Any

from markdown_blocks import block


def test_the_pages_codec_passes() -> None:
    page: dict[str, Any] = {}
    exec(block("docs/how-to/write-a-test.md", "Checks of extensions"), page)
    page["test_lines_keep_to_what_codecs_keep_to"]()
