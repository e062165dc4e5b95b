"""Our trackers beside those of ViSP and OpenCV: docs/trackers-table.md."""
