//! Contour error.
