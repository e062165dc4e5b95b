"""Inside the boxes of an FMU: reads, compiles and runs it as a controller."""
