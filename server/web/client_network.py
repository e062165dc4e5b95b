"""From where a request comes: guests of one network count as one, since cookies cost nothing."""

from flask_limiter.util import get_remote_address

from seamark.server.accounts import accounts
from seamark.server.web.address_prefix import IPV6_HOST_BITS, prefix
from seamark.server.web.services import services

IPV4_BITS, IPV6_BITS = 24, 48  # of the prefix that a provider gives to one customer at most


def network() -> str:
    """Return the keyed hash of the client's network."""
    return accounts.guest_hash(services().settings, f"network {shown()}")


def address() -> str:
    """Return the client's address; of an IPv6 address only the part that a host cannot choose."""
    return _prefix(32, IPV6_HOST_BITS)


def shown() -> str:
    """Return the client's network, for the log."""
    return _prefix(IPV4_BITS, IPV6_BITS)


def _prefix(bits_4: int, bits_6: int) -> str:
    text = get_remote_address()
    try:
        return prefix(text, bits_4, bits_6)
    except ValueError:  # of a Unix socket
        return text
