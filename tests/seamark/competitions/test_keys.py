"""Keys of rounds: fixed before the round, and none can be guessed from another one."""

import hashlib
import hmac
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.competitions.keys import commitment, final_label, round_key, seed
from seamark.sim.engine.seeds import SEED_MAX

KEY = bytes(range(32))


def test_round_keys_differ_in_each_argument_and_are_not_the_secret() -> None:
    cases = [(b"a", "reef", 1), (b"b", "reef", 1), (b"a", "reef-2", 1), (b"a", "reef", 2)]
    keys = {round_key(*case) for case in cases}

    assert len(keys) == len(cases)
    assert {len(key) for key in keys} == {32}


def test_a_round_key_never_changes() -> None:
    """Or the commitments that were published would be broken."""
    assert round_key(b"secret", "reef", 2).hex() == (
        "7c5f3d51dfa01f72ff1d80b6c570a662ab2a8a511463fc316257b8d5dd43ad7f"
    )


def test_the_commitment_is_the_sha_256_that_other_tools_compute() -> None:
    assert commitment(KEY) == hashlib.sha256(KEY).hexdigest()
    assert commitment(b"abc").startswith("ba7816bf8f01cfea")  # FIPS 180-2, B.1


def test_the_seeds_of_a_round_never_change() -> None:
    """Or an audit file could no longer be checked."""
    assert seed(KEY, "reef", "ab" * 32) == 7833175132530365422 & SEED_MAX


@given(st.binary(min_size=1), st.text(min_size=1), st.text(min_size=1))
def test_a_seed_is_one_that_a_practice_run_may_have(key: bytes, name: str, digest: str) -> None:
    assert 0 <= seed(key, name, digest) <= SEED_MAX


def test_seeds_differ_in_key_competition_and_submission() -> None:
    first = (KEY, "reef", final_label(1))
    cases = [first, (KEY[::-1], *first[1:]), (KEY, "wreck", first[2]), (*first[:2], final_label(2))]
    seeds = {seed(*case) for case in cases}

    assert len(seeds) == len(cases)


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        (lambda: round_key(b"", "reef", 1), "secret"),
        (lambda: round_key(b"secret", "", 1), "name of a competition"),
        (lambda: round_key(b"secret", "reef", -1), "negative"),
        (lambda: commitment(b""), "key of the round is empty"),
        (lambda: final_label(0), "counted from 1"),
        (lambda: seed(b"", "reef", "ab"), "secret"),
        (lambda: seed(KEY, "", "ab"), "name of a competition"),
        (lambda: seed(KEY, "reef", ""), "digest"),
    ],
)
def test_an_empty_argument_is_an_error(wrong: Callable[[], object], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        wrong()


def test_the_formula_in_the_documentation_gives_the_seed() -> None:
    """Those who check a competition without this program follow it (docs/competitions.md)."""
    text = "\n".join(["seamark fresh seed", "reef", "final batch 1", "0"])
    first = hmac.new(KEY, text.encode(), hashlib.sha256).digest()[:8]

    assert int.from_bytes(first, "big") // 2 % 2**31 == seed(KEY, "reef", final_label(1))
