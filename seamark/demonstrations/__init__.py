"""Demonstrations: episodes of a benchmark's environment that a built-in expert drives, as files.

They are what imitation learning trains on. A demonstration has the observations and the actions of
`seamark.gym`, so that it can be replayed there. It needs the extra `demonstrations`.
"""
