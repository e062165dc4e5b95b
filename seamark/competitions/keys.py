"""The key of each round, its commitment, and the seeds that follow from the key.

A round has a key of its own, derived from the service's seed key. Before the round opens, its
commitment is published; after its end, the key. Everybody can then derive all seeds of the round,
and sees by the commitment that they were fixed before the first submission.

A round's key tells nothing about the service's key or about the keys of other rounds: they are
values of a pseudo-random function (HMAC-SHA256), none of which can be guessed from the others. So
the key of a practice round may be public while the final is to come, and workers and the database
that hold a round's key never need the service's.
"""

import hashlib
import hmac

from seamark.sim.engine.seeds import SEED_MAX, fresh_seed


def round_key(secret: bytes, competition: str, number: int) -> bytes:
    """Return the 32 bytes of a round's key.

    Parameters
    ----------
    secret
        The service's seed key.
    competition
        Its name, which never changes and is never given again.
    number
        Of the round.

    Raises
    ------
    ValueError
        If the secret or the name is empty or the number negative.
    """
    if not secret:
        raise ValueError("the secret of the round keys is empty")
    if not competition:
        raise ValueError("a round key needs the name of a competition")
    if number < 0:
        raise ValueError(f"the number of a round must not be negative, not {number}")
    purpose = f"seamark round key\n{competition}\n{number}"
    return hmac.new(secret, purpose.encode(), hashlib.sha256).digest()


def commitment(key: bytes) -> str:
    """Return what is published before a round: the SHA-256 of its key, in hex.

    The key has as many random bits as the digest, so nobody finds it by trying keys, and nobody
    finds another key of the same commitment, which would give other seeds.

    Raises
    ------
    ValueError
        If the key is empty.
    """
    if not key:
        raise ValueError("the key of the round is empty")
    return hashlib.sha256(key).hexdigest()


def final_label(batch: int) -> str:
    """Return what stands for the digest of a submission in a batch of a final, counted from 1.

    It is the same for all entries, so that they are all evaluated on the same trials.

    Raises
    ------
    ValueError
        If the batch is less than 1.
    """
    if batch < 1:
        raise ValueError(f"the batches of a final are counted from 1, not {batch}")
    return f"final batch {batch}"


def seed(key: bytes, competition: str, submission: str) -> int:
    """Return the seed of a run, from 0 to `SEED_MAX`.

    All trials of an entry have it, as those of a practice run have theirs: a trial's number is part
    of what its seed gives. So once the key is known, anybody can repeat the run as a practice run.

    Parameters
    ----------
    key
        Of the round.
    submission
        The digest of what was submitted, so that each submission of practice and qualification has
        water of its own; in a final, `final_label`.

    Raises
    ------
    ValueError
        If the key, the name of the competition or the digest is empty.
    """
    if not competition:
        raise ValueError("the seeds of a round need the name of a competition")
    return fresh_seed(key, competition, submission, 0) & SEED_MAX
