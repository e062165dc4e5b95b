"""What runs in boxes beside the programs of strangers: one script per kind of program.

The folder is bound into those boxes as a package of its own, so that it imports nothing of ours but
itself. Nothing in it is trusted by the other side.
"""
