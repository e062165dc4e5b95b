"""How a connected program ends early: as data, like one in a box."""

from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict


def no_answer(sentence: str) -> ProgramEnded:
    """Return that the program took too long."""
    return ProgramEnded(Outcome(verdict=Verdict.TIME_LIMIT, sentence=sentence))


def wrong_answer(sentence: str) -> ProgramEnded:
    """Return that the program broke the rules of its protocol."""
    return ProgramEnded(Outcome(verdict=Verdict.PROTOCOL_ERROR, sentence=sentence))


def disconnected(sentence: str) -> ProgramEnded:
    """Return that the program disconnected before the end."""
    return ProgramEnded(Outcome(verdict=Verdict.USER_ERROR, sentence=sentence))
