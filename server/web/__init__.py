"""What pages and API share: authentication, rate limits, problems, headers."""
