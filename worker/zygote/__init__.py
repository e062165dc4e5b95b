"""The warm simulator process that is forked for each run."""
