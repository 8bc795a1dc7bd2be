"""A USB CDC-ACM board at the kernel's virtual controller (vhci-hcd): the server's side of USB/IP.

``usb_port.py`` is the port, ``port.py`` what a configuration needs of it; ``vhci.py`` plugs it in, and
``usb_session.py`` is the time until it is pulled out. ``cdc_acm.py`` is the device as its host sees it, with
``usb_device.py`` (standard requests), ``endpoints.py`` (transfers that wait), ``descriptors.py`` and
``urb.py`` (the bytes of USB/IP); these are pure.
"""
