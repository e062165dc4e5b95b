"""Built-in position controllers, one file each, written with the public interface."""
