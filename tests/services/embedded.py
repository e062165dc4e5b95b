"""What `seamark up --json` prints."""

import json
import subprocess


def address_of(service: "subprocess.Popen[str]") -> str:
    """Return the address of a service that starts, once it is ready."""
    assert service.stdout is not None
    lines = []
    for line in service.stdout:
        lines.append(line)
        if line.startswith("}"):
            break
    address: str = json.loads("".join(lines))["address"]
    return address
