"""Bodies that are joined and touch: vehicles with arms, tools and objects in water."""
