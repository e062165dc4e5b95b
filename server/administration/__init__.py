"""What admins see and decide: workers, queue, accounts, disk. Every change has an audit entry."""
