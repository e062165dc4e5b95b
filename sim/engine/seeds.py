"""Seeds: the range that users may choose from, and those of ranked runs."""

import hashlib
import hmac

SEED_MAX = 2**31 - 1  # of a seed that a user chooses
REFERENCE, FRESH = "reference", "fresh"  # parts of a ranked run: on the public, on fresh seeds
SEED_BITS = 63  # fits a signed 64-bit column


def hidden_seed(secret: bytes, benchmark: str, trial: int) -> int:
    """Return the seed of a ranked trial of the first benchmark versions: the same for everybody.

    Raises
    ------
    ValueError
        If the secret is empty or the trial negative.
    """
    return _derived(secret, f"seamark hidden seed\n{benchmark}", trial)


def fresh_seed(secret: bytes, benchmark: str, submission: str, trial: int) -> int:
    """Return the seed of a fresh trial: it follows from the secret and from what was submitted.

    Parameters
    ----------
    submission
        Digest over everything that decides how the solution behaves.

    Raises
    ------
    ValueError
        If the secret or the digest is empty or the trial negative.
    """
    if not submission:
        raise ValueError("fresh seeds need the digest of a submission")
    return _derived(secret, f"seamark fresh seed\n{benchmark}\n{submission}", trial)


def _derived(secret: bytes, purpose: str, trial: int) -> int:
    """Return a seed by HMAC-SHA256 of purpose and trial."""
    if not secret:
        raise ValueError("the secret of the seeds is empty")
    if trial < 0:
        raise ValueError(f"trial must not be negative, not {trial}")
    code = hmac.new(secret, f"{purpose}\n{trial}".encode(), hashlib.sha256).digest()
    return int.from_bytes(code[:8], "big") >> (64 - SEED_BITS)
