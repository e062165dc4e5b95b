"""The part of an address that stands for a client or its network."""

import ipaddress

IPV6_HOST_BITS = 64  # of the prefix in which one computer chooses its addresses


def prefix(address: str, bits_4: int, bits_6: int) -> str:
    """Return the first bits of an address as a network; raises ValueError if it is none."""
    parsed = ipaddress.ip_address(address)
    if isinstance(parsed, ipaddress.IPv6Address) and parsed.ipv4_mapped is not None:
        parsed = parsed.ipv4_mapped
    bits = bits_4 if parsed.version == 4 else bits_6
    return str(ipaddress.ip_network(f"{parsed}/{bits}", strict=False))


def host(address: str) -> str:
    """Return an address without the bits that a host chooses; raises ValueError if it is none."""
    return prefix(address, ipaddress.IPV4LENGTH, IPV6_HOST_BITS)
