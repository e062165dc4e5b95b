"""A BlueROV2 that floats and moves its arm, measured in a wave laboratory, against the engine.

`trials.csv` is an excerpt of `hkolano/UVMS-SysID-with-EAs` (MIT, see LICENSE): `records` makes it.
"""
