"""How much room the scores of a benchmark leave, from doing nothing to the oracle."""
