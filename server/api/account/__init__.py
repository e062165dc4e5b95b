"""The account of a token: its data, mail addresses, profile and classes."""
