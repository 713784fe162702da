//! Angles of three probes: the best pairs and the noise gain of a given one.
