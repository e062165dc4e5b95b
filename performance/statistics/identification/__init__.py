"""Tank days of a simulated vehicle, and how often intervals from their logs hold the truth."""
