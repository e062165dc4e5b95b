"""Inside the boxes of C and C++: compiles the source, and starts the compiled program."""
