//! Involute helicoids on five axes: inputs, grid, program.
