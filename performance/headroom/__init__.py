"""How much room the scores of currents-v2 leave, from doing nothing to the oracle."""
