"""The documentation: pages of the site, Markdown of docs/, navigation and search."""
