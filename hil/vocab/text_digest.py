"""Digest of texts: what a run, or a drawing, is known by wherever it is told of."""

import hashlib

DIGEST_BYTES = 16
"""Length of a digest: nobody finds two texts with the same by chance."""


def text_digest(*texts: str) -> str:
    """Digest of texts, one after the other, in hexadecimal digits."""
    whole = hashlib.blake2b(digest_size=DIGEST_BYTES)
    for text in texts:
        content = text.encode(errors="surrogatepass")
        whole.update(len(content).to_bytes(8))
        whole.update(content)
    return whole.hexdigest()
