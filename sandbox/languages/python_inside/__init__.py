"""Runs inside the box, beside the program of a stranger. Nothing here is trusted by our side.

The folder is seen there as the package `seamark_runner`: a box holds nothing else of ours. The
frames are described in sandbox/protocol/messages.py; their numbers stand here once more.
"""
