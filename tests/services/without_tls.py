"""For the option `verify` of httpx, of requests to servers without TLS."""

import ssl

# Trusts nobody. A request by itself reads the usual certificates, which takes 30 ms.
WITHOUT_TLS = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
