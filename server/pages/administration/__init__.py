"""The administration: the state of the service, its accounts and what admins change."""
