"""The pictures of pages and documentation."""
