"""The `seamark` command."""


def main() -> None:
    """Run the command line."""
