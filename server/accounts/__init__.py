"""Accounts and permissions."""
