"""Pages, styles and scripts that the server shows."""
