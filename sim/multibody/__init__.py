"""Bodies that are joined and touch: vehicles with arms, tools, objects; with the same bits everywhere."""
