"""Pages and streams beside others, downloads, and what a browser shows when."""
