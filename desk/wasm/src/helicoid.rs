//! Involute helicoids on five axes.
