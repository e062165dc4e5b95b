"""The account: signing up and in, its page, mail addresses, invitations, public profiles."""
