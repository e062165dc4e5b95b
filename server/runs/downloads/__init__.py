"""Downloads that are made while they are sent: other formats, and all of an account."""
