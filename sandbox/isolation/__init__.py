"""The processes of a box, and every layer that confines them."""
