"""A TCP listener that carries raw bytes, as ``socket://`` of pyserial and ``nc`` speak them."""
