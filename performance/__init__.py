"""Speed and memory compared with other libraries, measured in the same run."""
