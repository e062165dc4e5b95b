"""Seeds: the range that users may choose from, and the hidden seeds of ranked runs."""

import hashlib
import hmac

SEED_MAX = 2**31 - 1  # of a seed that a user chooses
SEED_BITS = 63  # fits a signed 64-bit column


def hidden_seed(secret: bytes, benchmark: str, trial: int) -> int:
    """Return the hidden seed of a ranked trial: HMAC-SHA256 of benchmark and trial.

    Raises
    ------
    ValueError
        If the secret is empty or the trial negative.
    """
    if not secret:
        raise ValueError("the secret of the hidden seeds is empty")
    if trial < 0:
        raise ValueError(f"trial must not be negative, not {trial}")
    message = f"seamark hidden seed\n{benchmark}\n{trial}".encode()
    code = hmac.new(secret, message, hashlib.sha256).digest()
    return int.from_bytes(code[:8], "big") >> (64 - SEED_BITS)
