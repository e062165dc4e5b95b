"""The end of a run: its result, its cancellation, its deletion."""
