"""What the scripts of several languages share inside a box. It imports nothing else of ours.

The simulator trusts none of it: it runs beside the user's program.
"""
