"""A USB CDC-ACM board at the kernel's virtual controller (vhci-hcd): the server's side of USB/IP."""
