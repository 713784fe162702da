//! Reference circles: least squares, minimum zone, maximum inscribed, minimum circumscribed.
