"""`python -m performance.validation [--out docs/validation.md]`: compute and write the page."""

import argparse
from pathlib import Path

from performance.validation import page


def main() -> None:
    """Write the page and say where it is."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/validation.md"))
    options = parser.parse_args()
    page.write(options.out)
    print(f"wrote {options.out}")


if __name__ == "__main__":
    main()
