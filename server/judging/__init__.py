"""How competitions are decided: entries, reference entries, boards, finals and what proves them."""
