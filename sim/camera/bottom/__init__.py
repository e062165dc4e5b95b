"""A sea bottom with things on it, painted anew for every level: objects among decoys."""
