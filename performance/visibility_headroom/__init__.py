"""How visibility-v2 spreads its entries, from doing nothing to the oracle."""
