"""Engine, tables and schema."""
