"""What admins see and change, and rejudgements."""
