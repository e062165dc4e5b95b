"""Runs: submission, queue, states, results, views, leaderboard."""
