"""Inside the box of a MATLAB program: GNU Octave, and the relay that speaks the protocol for it."""
