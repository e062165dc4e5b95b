"""The row of a run: its states, its columns, and what is kept in step with it."""
