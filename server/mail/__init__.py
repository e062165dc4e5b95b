"""E-mail of the service: addresses of accounts, an outbox in the database, its sender."""
