"""How the water of a level moves, where more is known of it than a mean speed.

A place's profile and turbulence, a record of currents, and surface waves are put into one table of
the water's velocity (`physics.current.Table`) before a level begins. All of it comes from sums,
products and the house's own elementary functions, so every processor makes the same bits.
"""
