"""The leaderboards, with the replay of the leader and the history of a rank."""
