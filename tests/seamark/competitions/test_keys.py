"""Keys of rounds: fixed before the round, and none can be guessed from another one."""

import hashlib
from collections.abc import Callable

import pytest

from seamark.competitions.keys import commitment, final_label, round_key, trial_seeds

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
    assert trial_seeds(KEY, "reef", "ab" * 32, 2, shared=False) == [
        7833175132530365422,
        7291718718479102006,
    ]


def test_trials_have_seeds_of_their_own_unless_they_share_that_of_the_first() -> None:
    own = trial_seeds(KEY, "reef", "ab" * 32, 4, shared=False)
    shared = trial_seeds(KEY, "reef", "ab" * 32, 4, shared=True)

    assert len(set(own)) == 4
    assert shared == [own[0]] * 4


def test_more_trials_do_not_change_the_seeds_of_the_first() -> None:
    few = trial_seeds(KEY, "reef", "ab" * 32, 3, shared=False)
    many = trial_seeds(KEY, "reef", "ab" * 32, 24, shared=False)

    assert many[:3] == few


def test_seeds_differ_in_key_competition_and_submission() -> None:
    first = (KEY, "reef", final_label(1))
    cases = [first, (KEY[::-1], *first[1:]), (KEY, "wreck", first[2]), (*first[:2], final_label(2))]
    seeds = {trial_seeds(*case, 1, shared=False)[0] for case in cases}

    assert len(seeds) == len(cases)


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        (lambda: round_key(b"", "reef", 1), "secret"),
        (lambda: round_key(b"secret", "", 1), "name of a competition"),
        (lambda: round_key(b"secret", "reef", -1), "negative"),
        (lambda: commitment(b""), "key of the round is empty"),
        (lambda: final_label(0), "counted from 1"),
        (lambda: trial_seeds(b"", "reef", "ab", 1, shared=False), "secret"),
        (lambda: trial_seeds(KEY, "", "ab", 1, shared=False), "name of a competition"),
        (lambda: trial_seeds(KEY, "reef", "", 1, shared=False), "digest"),
        (lambda: trial_seeds(KEY, "reef", "ab", 0, shared=True), "at least one trial"),
    ],
)
def test_an_empty_argument_is_an_error(wrong: Callable[[], object], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        wrong()
