"""The template tracker: Gauss-Newton alignment of a textured plane."""
