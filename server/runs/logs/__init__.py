"""Logs of missions that users upload, kept and shown beside runs."""
