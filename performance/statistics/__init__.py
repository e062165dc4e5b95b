"""What scores mean: their intervals, their room, and what wins without merit."""
