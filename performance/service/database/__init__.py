"""Pages and queries of databases with many rows."""
